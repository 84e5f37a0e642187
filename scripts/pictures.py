"""Makes pictures of the documentation in a window of Blender under Xvfb.

They are the README's animation and the manual's. Pictures 1 to 6 come from the shots of the window test `bunny`, if it
was run before.

    scripts/pictures.py [--keep] [--asset | --planes]
        --keep: composes the shots that are in out/pictures again; --asset: only the six steps to a game asset;
        --planes: only picture 10

It needs blender, xvfb and imagemagick of Debian, Pillow, the engine (PYTHONPATH or installed), the bunny and the castle
in $ISIMP_DATA or ../shared/data. The scan of the six steps is made here, by bench/generators/painted_scans.py.
"""

import argparse
import json
import os
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "pictures"
IMAGES = ROOT / "docs" / "images"
WINDOW = ROOT / "tests" / "python" / "blender" / "window"
SIZE = 1150, 780  # pixels of the window
HIGH = 1150, 1000  # the same where the panel is long
WIDE = 760  # pixels of the animation
ASSET = 380, 130, 780, 690  # part of the window in the pictures of the six steps
STEPS = 979, 575, 1170, 728  # place of the section Steps in the window of that test
MOST = 3_000_000  # bytes of it


def shoot(script: str, size: tuple[int, int] = SIZE) -> None:
    OUT.mkdir(parents=True, exist_ok=True)
    sites = [str(ROOT / "addon"), str(WINDOW), str(WINDOW.parent), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    sites += [path for path in sys.path if path.endswith("-packages")]
    blender = ["blender", "--factory-startup", "--enable-event-simulate", "-p", "0", "0", *map(str, size)]
    driven = ["--python", str(WINDOW / "drive.py"), "--", str(ROOT / "scripts" / script), str(OUT)]
    command = ["xvfb-run", "-a", "-s", f"-screen 0 {size[0]}x{size[1]}x24", *blender, *driven]
    environment = os.environ | {"ISIMP_SITE": os.pathsep.join(filter(None, sites))}
    subprocess.run(command, env=environment, check=True, timeout=1200)


def animate() -> None:
    """The frames as one WebP; viewers without animation show the first."""
    film = json.loads((OUT / "film.json").read_text())
    frames = []
    for name, _ in film["frames"]:
        with Image.open(OUT / f"{name}.png") as shot:
            frame = shot.convert("RGB").crop(tuple(film["box"]))
        frames.append(frame.resize((WIDE, round(WIDE * frame.height / frame.width)), Image.Resampling.LANCZOS))
    target, times = IMAGES / "isimp.webp", [milliseconds for _, milliseconds in film["frames"]]
    for quality in (85, 75, 65, 50):
        more = {"save_all": True, "append_images": frames[1:], "duration": times, "loop": 0, "method": 6}
        frames[0].save(target, quality=quality, **more)
        if target.stat().st_size < MOST:
            break
    print(f"{target}: {len(frames)} frames, {sum(times) / 1000:.1f} s, {target.stat().st_size:,} bytes")


def compose() -> None:
    """Pictures 7 to 9 of the manual: views without the sidebar, side by side."""
    left, top, right, bottom = json.loads((OUT / "film.json").read_text())["box"]
    box = left, top + 26, right - 262, bottom
    for target, names in {
        "manual-7-gestures": ["picture-7-cut", "picture-7-shrink"],
        "manual-8-paint": ["picture-8-paint"],
        "manual-9-compare": ["picture-9-compare"],
    }.items():
        shots = [Image.open(OUT / f"{name}.png").convert("RGB").crop(box) for name in names]
        whole = Image.new("RGB", (sum(shot.width for shot in shots) + 8 * (len(shots) - 1), shots[0].height), "white")
        for number, shot in enumerate(shots):
            whole.paste(shot, (number * (shot.width + 8), 0))
        whole.thumbnail((1150, 900), Image.Resampling.LANCZOS)
        whole.save(IMAGES / f"{target}.jpg", quality=88)


def compose_planes() -> None:
    """Picture 10 of the manual: the view and the panel."""
    shot = Image.open(OUT / "picture-10-regularity.png").convert("RGB")
    shot = shot.crop((shot.width - 785, 70, shot.width, shot.height - 20))
    shot.save(IMAGES / "manual-10-regularity.jpg", quality=86)


def make_owl() -> None:
    """The scan of the six steps, as a file of arrays."""
    OUT.mkdir(parents=True, exist_ok=True)
    made = runpy.run_path(str(ROOT / "bench" / "generators" / "painted_scans.py"))["owl"](60_000)
    image = made.images["painted"]
    np.savez(OUT / "owl.npz", vertices=made.vertices, triangles=made.triangles, uv=made.uv, image=image)


def compose_asset() -> None:
    """The six steps, without the parts of the window that do not matter."""
    left, top, right, bottom = ASSET
    for number, name in enumerate(("scan", "regions", "clicks", "polygons", "texture", "levels"), 1):
        shot = Image.open(OUT / f"asset-{number}-{name}.png").convert("RGB")
        box = (left, top, right, bottom) if name != "levels" else (180, top + 60, 876, bottom - 60)
        shot = shot.crop(box)
        shot.thumbnail((560, 440), Image.Resampling.LANCZOS)
        shot.save(IMAGES / f"asset-{number}-{name}.jpg", quality=84)


def compose_bunny() -> None:
    """Pictures 1 to 6 of the manual."""
    for number, name in enumerate(("scan", "partition", "hover", "flatness", "steps", "mesh"), 1):
        path = ROOT / "out" / "window" / f"bunny-{number}-{name}.png"
        if not path.exists():
            print(f"no {path}: picture {number} is not changed")
            continue
        shot = Image.open(path).convert("RGB")
        box = STEPS if name == "steps" else (0, 0, shot.width, round(0.775 * shot.width))
        shot = shot.crop(box).resize((860, 667) if name != "steps" else (400, 320), Image.Resampling.LANCZOS)
        shot.save(IMAGES / f"manual-{number}-{name}.jpg", quality=88)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--keep", action="store_true", help="compose the shots that are in out/pictures again")
    parser.add_argument("--planes", action="store_true", help="only picture 10 of the manual")
    parser.add_argument("--asset", action="store_true", help="only the six steps to a game asset")
    asked = parser.parse_args()
    if not asked.asset:
        if not asked.keep:
            shoot("planes_in_window.py", HIGH)
        compose_planes()
    if not asked.planes:
        if not asked.keep:
            make_owl()
            shoot("asset_in_window.py")
        compose_asset()
    if not (asked.asset or asked.planes):
        if not asked.keep:
            shoot("pictures_in_window.py")
        animate()
        compose()
        compose_bunny()
