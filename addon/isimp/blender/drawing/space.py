"""Sets matrices and graphics state for drawing over a scan: its transform, a little nearer to the eye."""

from contextlib import contextmanager

import gpu
from mathutils import Matrix, Vector

from ..scene import mesh_io

#: Offset of lines towards the eye, as a share of the scan's size, so that the faces below do not hide them
ON = 0.003


class Over:
    """Context of the scan's own space, offset towards the eye. The graphics state is restored at the end."""

    def __init__(self, view, scan):
        self.place = Matrix(mesh_io.place_matrix(scan).tolist())
        middle = sum((Vector(corner) for corner in scan.bound_box), Vector()) / 8
        self.away = max(1e-6, -(view.view_matrix @ scan.matrix_world @ middle).z)
        self.size = scan.dimensions.length
        self.is_perspective = view.is_perspective

    def pixels(self, context) -> float:
        """Return the length in pixels of one unit of the scan's space at the scan's middle."""
        high = 0.5 * context.region.height * self.projection[1][1]
        return high / self.away if self.is_perspective else high

    def nearer(self, share: float) -> None:
        """Offsets following draws towards the eye by this share of the scan's size."""
        projection = self.projection.copy()
        depth = projection[2][3] / self.away**2 if self.is_perspective else projection[2][2]
        projection[2] = projection[2] - abs(depth) * share * self.size * projection[3]
        gpu.matrix.load_projection_matrix(projection)

    @contextmanager
    def at(self, origin):
        """Sets the origin of draws to a point in the scan's space."""
        gpu.matrix.push()
        gpu.matrix.translate(origin)
        try:
            yield
        finally:
            gpu.matrix.pop()

    def __enter__(self):
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(False)
        gpu.state.blend_set("ALPHA")
        gpu.matrix.push()
        gpu.matrix.multiply_matrix(self.place)
        gpu.matrix.push_projection()
        self.projection = gpu.matrix.get_projection_matrix()
        self.nearer(ON)
        return self

    def __exit__(self, *_):
        gpu.matrix.pop_projection()
        gpu.matrix.pop()
        gpu.state.blend_set("NONE")
        gpu.state.depth_mask_set(True)
        gpu.state.depth_test_set("NONE")
        gpu.state.point_size_set(1.0)
