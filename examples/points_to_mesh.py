"""Makes a mesh from a scan of points, by screened Poisson reconstruction.

    pip install pymeshlab            # for .las and .laz also: pip install 'laspy[lazrs]'
    python examples/points_to_mesh.py POINTS MESH.ply [--depth 9] [--trim 3]

POINTS: .ply, .xyz, .pts, .e57 or another file that MeshLab reads, .las or .laz. Points without normals get some, from
their neighbours. Faces whose corners are farther from the points than --trim mean distances between points are removed:
Poisson reconstruction closes every hole. docs/points.md describes the choices.
"""

import argparse
from pathlib import Path

import numpy as np
import pymeshlab

NEIGHBOURS = 16  # points that a normal is fitted to


def read(path):
    """Points (N, 3), and their normals (N, 3), None where the file has none."""
    if path.suffix.lower() in (".las", ".laz"):
        import laspy

        return np.asarray(laspy.read(path).xyz), None
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    loaded = meshes.current_mesh()
    normals = loaded.vertex_normal_matrix()
    return loaded.vertex_matrix(), normals if np.linalg.norm(normals, axis=1).all() else None


def reconstruct(points, normals, depth, trim):
    """Vertices (V, 3) and triangles (F, 3)."""
    meshes = pymeshlab.MeshSet()
    given = {} if normals is None else {"v_normals_matrix": normals}
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points, **given))
    if normals is None:
        meshes.compute_normal_for_point_clouds(k=NEIGHBOURS)
    meshes.generate_surface_reconstruction_screened_poisson(depth=depth, threads=1)
    meshes.compute_scalar_by_distance_from_another_mesh_per_vertex(measuremesh=1, refmesh=0, signeddist=False)
    made = meshes.current_mesh()
    vertices, triangles = made.vertex_matrix(), made.face_matrix()
    far = made.vertex_scalar_array() > trim * np.sqrt(area(vertices, triangles) / len(points))
    return vertices, triangles[~far[triangles].any(axis=1)]


def area(vertices, triangles):
    a, b, c = vertices[triangles].swapaxes(0, 1)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("points", type=Path, metavar="POINTS")
    parser.add_argument("mesh", type=Path, metavar="MESH.ply")
    parser.add_argument("--depth", type=int, default=9, help="each step more has half the cell. Default: %(default)s")
    parser.add_argument("--trim", type=float, default=3, help="in mean distances of points. Default: %(default)s")
    asked = parser.parse_args()
    points, normals = read(asked.points)
    middle = points.mean(axis=0).round()  # map coordinates are too large for the single precision inside
    vertices, triangles = reconstruct(points - middle, normals, asked.depth, asked.trim)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices + middle, triangles))
    meshes.meshing_remove_unreferenced_vertices()
    meshes.save_current_mesh(str(asked.mesh), binary=True)
    print(f"{asked.mesh}: {len(points):,} points became {len(triangles):,} triangles")


if __name__ == "__main__":
    main()
