#pragma once

#include "isimp/mesh/mesh.h"
#include "isimp/meshing/polygonize.h"
#include "isimp/partition/partition.h"
#include "tests.h"

/// Partitions made by hand, and the meshes of the data folder.
namespace isimp::labelled {

/// Regions given face by face.
/// \param regions  kNone leaves a face out
Partition by(std::vector<std::int32_t> regions);
/// Faces that have the same normal and lie in the same plane, to 1e-4.
Partition planes(const Mesh& mesh);
/// Connected regions grown from `count` faces drawn by `seed`, breadth first.
Partition voronoi(const Mesh& mesh, int count, std::uint32_t seed);
/// Each face in a region drawn by `seed`: no region is connected.
Partition noise(const Mesh& mesh, int count, std::uint32_t seed);
/// A partition of one region; a partition with a region for each face.
Partition single(const Mesh& mesh);
Partition each(const Mesh& mesh);

/// The polygons of a partition.
PolygonMesh meshed(const Mesh& mesh, const Partition& partition, const MeshingOptions& options = {});

/// The folder of test scans, "" if there is none: the environment's ISIMP_DATA, else next to the source tree.
std::string data_folder();
/// The true regions of data/known/<name>.ply.
Partition read_labels(const std::string& path);

}  // namespace isimp::labelled
