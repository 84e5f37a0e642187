// The Python functions that make atlases and bake; all of them are private to the package.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/core/errors.h"
#include "isimp/texture/bake.h"
#include "isimp/texture/closest_places.h"
#include "isimp/texture/corners.h"
#include "isimp/texture/occlusion.h"
#include "isimp/texture/unwrap.h"
#include "kept_mesh.h"
#include "options.h"

namespace isimp::bindings {

using namespace py::literals;

namespace {

template <class T>
using Contiguous = py::array_t<T, py::array::c_style>;

template <class T>
std::span<const T> span_of(const Contiguous<T>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// UVs from 0 to 1 in the tile of each corner's polygon.
py::array uv_of(const PolygonMesh& poly, const Atlas& atlas) {
  if (atlas.corner.size() != poly.loops.size() || atlas.tile.size() != poly.loop_start.size())
    throw InvalidInput("the atlas is not of these polygons");
  Contiguous<double> uv({static_cast<py::ssize_t>(atlas.corner.size()), py::ssize_t{2}});
  double* out = uv.mutable_data();
  std::size_t i = 0;
  for (std::size_t q = 0; q < atlas.tile.size(); ++q) {
    const std::size_t end =
        q + 1 < atlas.tile.size() ? static_cast<std::size_t>(poly.loop_start[q + 1]) : atlas.corner.size();
    for (; i < end; ++i) {
      *out++ = atlas.corner[i][0] / atlas.side;
      *out++ = atlas.corner[i][1] / atlas.side - atlas.tile[q];
    }
  }
  return uv;
}

/// One direction of each polygon, (Q, 3).
py::array directions(const Atlas& atlas, Vec3 ChartFrame::*member) {
  std::vector<Vec3> all;
  all.reserve(atlas.frame.size());
  for (const ChartFrame& frame : atlas.frame) all.push_back((frame.*member).normalized());
  return owned(std::move(all));
}

Picture picture_of(const py::handle& item, std::size_t i) {
  const auto array = py::cast<py::array>(item);
  if (array.ndim() != 3 || array.shape(2) != 4 || (array.flags() & py::array::c_style) == 0)
    throw InvalidInput("image " + std::to_string(i) + " must be a contiguous array of shape (H, W, 4)");
  Picture picture;
  picture.height = static_cast<std::int32_t>(array.shape(0));
  picture.width = static_cast<std::int32_t>(array.shape(1));
  const auto size = static_cast<std::size_t>(array.size());
  if (array.dtype().equal(py::dtype::of<std::uint8_t>()))
    picture.bytes = {static_cast<const std::uint8_t*>(array.data()), size};
  else if (array.dtype().equal(py::dtype::of<std::uint16_t>()))
    picture.words = {static_cast<const std::uint16_t*>(array.data()), size};
  else
    throw InvalidInput("image " + std::to_string(i) + " must hold uint8 or uint16");
  return picture;
}

/// (rows, side, channels), without the last axis where there is one channel.
template <class T, class Allocator>
py::array pixels(std::vector<T, Allocator>&& values, std::int32_t side, std::int32_t channels) {
  const auto n = static_cast<py::ssize_t>(side);
  const py::array flat = owned(std::move(values));
  return channels == 1 ? flat.attr("reshape")(-1, n) : flat.attr("reshape")(-1, n, channels);
}

/// A layer given as (uv, image, pictures). `kept` holds the arrays that it refers to.
Appearance layer_of(const py::handle& item, std::vector<py::object>& kept) {
  auto [uv, image, pictures] = py::cast<std::tuple<Contiguous<float>, Contiguous<std::int32_t>, py::list>>(item);
  Appearance look{span_of(uv), span_of(image), {}, {}, {}};
  for (std::size_t i = 0; i < pictures.size(); ++i) look.pictures.push_back(picture_of(pictures[i], i));
  for (const py::object& array : {py::object(uv), py::object(image), py::object(pictures)}) kept.push_back(array);
  return look;
}

py::array texels_of(const std::vector<PolygonTexels>& texels) {
  Contiguous<std::int64_t> counts({static_cast<py::ssize_t>(texels.size()), py::ssize_t{3}});
  std::int64_t* out = counts.mutable_data();
  for (const PolygonTexels& polygon : texels)
    for (const std::int64_t count : {polygon.inside, polygon.searched, polygon.unknown}) *out++ = count;
  return counts;
}

/// The arrays of `_Look` of texturing/baking.py, without its pictures: uv, image, colors, known.
using Look =
    std::tuple<Contiguous<float>, Contiguous<std::int32_t>, Contiguous<std::uint8_t>, Contiguous<std::uint8_t>>;

py::tuple bake_texture(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly, const Atlas& atlas,
                       const Look& arrays, const py::list& pictures, const py::list& layers, const py::object& relief,
                       const TextureOptions& options, Job* job) {
  const auto& [uv, image, colors, known] = arrays;
  Appearance look{span_of(uv), span_of(image), span_of(colors), span_of(known), {}};
  for (std::size_t i = 0; i < pictures.size(); ++i) look.pictures.push_back(picture_of(pictures[i], i));
  MaterialLayers more;
  std::vector<py::object> kept;
  for (const py::handle& layer : layers) more.images.push_back(layer_of(layer, kept));
  if (!relief.is_none()) more.relief = layer_of(relief, kept);
  Texture made = call(job, [&, options](Job& j) { return bake(mesh, part, poly, atlas, look, options, j, more); });
  py::list images;
  for (Array<std::uint8_t>& layer : made.layers) images.append(pixels(std::move(layer), made.side, 4));
  const py::object normal =
      made.normal.empty() ? py::object(py::none()) : py::object(pixels(std::move(made.normal), made.side, 3));
  return py::make_tuple(pixels(std::move(made.color), made.side, 4), normal, images, texels_of(made.texels));
}

/// Ambient occlusion, (rows, side).
py::array occlusion_of(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly, const Atlas& atlas,
                       const TextureOptions& options, Job* job) {
  Array<std::uint8_t> dark = call(job, [&, options](Job& j) {
    BakeMap map;
    {
      const Job::Stage mapping(j, "baking", 0.3, 0.4);
      map = bake_map(mesh, part, poly, atlas, options, j);
    }
    const Job::Stage tracing(j, "occlusion", 0.4, 0.98);
    return occlusion(mesh, part, map, options, j);
  });
  return pixels(std::move(dark), atlas.side, 1);
}

py::tuple map_texture(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly, const Atlas& atlas,
                      const TextureOptions& options, Job* job) {
  BakeMap map = call(job, [&, options](Job& j) { return bake_map(mesh, part, poly, atlas, options, j); });
  return py::make_tuple(pixels(std::move(map.polygon), map.side, 1), pixels(std::move(map.face), map.side, 1),
                        pixels(std::move(map.barycentric), map.side, 2));
}

/// \param group  (Q) of each polygon, or of no length
Atlas lay_out(const PolygonMesh& poly, const TextureOptions& options, double density,
              const Contiguous<std::int32_t>& group, Job* job) {
  check_fields(options);
  if (group.size() != 0 && group.size() != static_cast<py::ssize_t>(poly.loop_start.size()))
    throw InvalidInput("there must be a group for each polygon");
  const AtlasOptions asked{options.size.value_or(0),  density,       options.unfold, options.gutter.value_or(0),
                           options.tiles.value_or(0), span_of(group)};
  return call(job, [&](Job& j) { return unwrap(poly, asked, j); });
}

py::tuple places_of(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly,
                    const Contiguous<std::uint8_t>& known, const Contiguous<std::int32_t>& group, std::int32_t threads,
                    Job* job) {
  CornerPlaces found =
      call(job, [&](Job& j) { return closest_places(mesh, part, poly, span_of(known), span_of(group), threads, j); });
  const auto corners = static_cast<py::ssize_t>(found.face.size());
  const py::array weight = owned(std::move(found.barycentric));
  return py::make_tuple(owned(std::move(found.face)), weight.attr("reshape")(corners, 2));
}

py::tuple corners_of(const KeptMesh& mesh, const py::object& vertices, const py::object& triangles, Job* job) {
  const auto points = read_vertices(vertices);
  const auto corners = read_triangles(triangles, points.size());
  for (std::size_t f = 0; f < corners.size(); ++f)
    for (const std::int32_t v : corners[f])
      if (v < 0 || static_cast<std::size_t>(v) >= points.size())
        throw InvalidInput("face " + std::to_string(f) + " uses vertex " + std::to_string(v) + ", but there are " +
                           std::to_string(points.size()) + " vertices");
  SourceCorners found = call(job, [&](Job& j) { return source_corners(mesh, points, corners, j); });
  Contiguous<float> weight({static_cast<py::ssize_t>(found.weight.size()), py::ssize_t{3}, py::ssize_t{2}});
  float* out = weight.mutable_data();
  for (const auto& w : found.weight) out = std::copy(w.begin(), w.end(), out);
  return py::make_tuple(owned(std::move(found.face)), weight, found.turned, found.lost);
}

}  // namespace

void bind_texture(py::module_& m) {
  OptionsClass<TextureOptions>(m, "TextureOptions", "How to make a texture of polygons. All fields are keywords.");
  py::class_<Atlas>(m, "_Atlas", py::module_local(), "Polygons laid out in a square of texels.")
      .def_readonly("side", &Atlas::side)
      .def_readonly("scale", &Atlas::scale)
      .def_readonly("fill", &Atlas::fill)
      .def_readonly("gutter", &Atlas::gutter)
      .def_readonly("tiles", &Atlas::tiles)
      .def_readonly("chart_count", &Atlas::chart_count)
      .def_property_readonly("chart", viewer<Atlas>(&Atlas::chart))
      .def_property_readonly("tile", viewer<Atlas>(&Atlas::tile))
      .def_property_readonly("tile_group", viewer<Atlas>(&Atlas::tile_group))
      .def_property_readonly("tangent", [](const Atlas& atlas) { return directions(atlas, &ChartFrame::u); })
      .def_property_readonly("normal", [](const Atlas& atlas) { return directions(atlas, &ChartFrame::n); });
  m.def("_unwrap", &lay_out, "polygons"_a, "options"_a, "density"_a, "group"_a = Contiguous<std::int32_t>(),
        "job"_a = py::none());
  m.def("_uv", &uv_of, "polygons"_a, "atlas"_a);
  m.def("_bake", &bake_texture, "mesh"_a, "partition"_a, "polygons"_a, "atlas"_a, "look"_a, "pictures"_a, "layers"_a,
        "relief"_a, "options"_a, "job"_a = py::none());
  m.def("_bake_map", &map_texture, "mesh"_a, "partition"_a, "polygons"_a, "atlas"_a, "options"_a, "job"_a = py::none());
  m.def("_occlusion", &occlusion_of, "mesh"_a, "partition"_a, "polygons"_a, "atlas"_a, "options"_a,
        "job"_a = py::none());
  m.def("_closest_places", &places_of, "mesh"_a, "partition"_a, "polygons"_a, "known"_a,
        "group"_a = Contiguous<std::int32_t>(), "threads"_a = 0, "job"_a = py::none());
  m.def("_source_corners", &corners_of, "mesh"_a, "vertices"_a, "triangles"_a, "job"_a = py::none());
}

}  // namespace isimp::bindings
