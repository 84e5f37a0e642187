"""Makes the small pictures on the cards of presets from pictures in docs/images: their regions, without the ground.

python scripts/preset_pictures.py     (needs Pillow)
"""

from pathlib import Path

from PIL import Image, ImageChops

ROOT = Path(__file__).resolve().parents[1]
WIDE = 64  # pixels
NAMES = {name: name for name in ("figure", "building", "city", "cad", "generated")} | {"low_poly": "low-poly"}


def card(path: Path) -> Image.Image:
    """The left half of a picture, which shows the regions, as a square with a see-through ground."""
    whole = Image.open(path).convert("RGB")
    half = whole.crop((0, 0, whole.width // 2, whole.height))
    far = ImageChops.difference(half, Image.new("RGB", half.size, "white")).convert("L")
    seen = far.point(lambda value: 255 if value > 24 else 0)
    made = half.convert("RGBA")
    made.putalpha(seen)
    made = made.crop(seen.getbbox())
    side = max(made.size)
    square = Image.new("RGBA", (side, side))
    square.paste(made, ((side - made.width) // 2, (side - made.height) // 2))
    return square.resize((WIDE, WIDE), Image.Resampling.LANCZOS)


for name, picture in NAMES.items():
    made = card(ROOT / "docs" / "images" / f"preset-{picture}.jpg")
    made.save(ROOT / "addon" / "isimp" / "pictures" / f"{name}.png", optimize=True)
