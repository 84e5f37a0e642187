#include <pybind11/numpy.h>
#include <pybind11/stl.h>

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
#include "isimp/texture/height.h"
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

py::array uv_of(const Atlas& atlas) {
  Contiguous<double> uv({static_cast<py::ssize_t>(atlas.corner.size()), py::ssize_t{2}});
  double* out = uv.mutable_data();
  for (const auto& p : atlas.corner)
    for (const double at : p) *out++ = at / atlas.side;
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

template <class T, class Allocator>
py::array pixels(std::vector<T, Allocator>&& values, std::int32_t side, std::int32_t channels) {
  const auto n = static_cast<py::ssize_t>(side);
  const py::array flat = owned(std::move(values));
  return channels == 1 ? flat.attr("reshape")(n, n) : flat.attr("reshape")(n, n, channels);
}

/// A layer given as (uv, image, pictures). `kept` holds the arrays that it looks at.
Appearance layer_of(const py::handle& item, std::vector<py::object>& kept) {
  auto [uv, image, pictures] = py::cast<std::tuple<Contiguous<float>, Contiguous<std::int32_t>, py::list>>(item);
  Appearance look{span_of(uv), span_of(image), {}, {}, {}};
  for (std::size_t i = 0; i < pictures.size(); ++i) look.pictures.push_back(picture_of(pictures[i], i));
  for (const py::object& array : {py::object(uv), py::object(image), py::object(pictures)}) kept.push_back(array);
  return look;
}

py::tuple bake_texture(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly, const Atlas& atlas,
                       const Contiguous<float>& uv, const Contiguous<std::int32_t>& image,
                       const Contiguous<std::uint8_t>& colors, const Contiguous<std::uint8_t>& known,
                       const py::list& pictures, const py::list& layers, const py::object& relief,
                       const TextureOptions& options, Job* job) {
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
  return py::make_tuple(pixels(std::move(made.color), made.side, 4), normal, images,
                        py::dict("texels"_a = made.report.texels, "searched"_a = made.report.searched,
                                 "unknown"_a = made.report.unknown));
}

py::array occlusion_texture(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly, const Atlas& atlas,
                            const TextureOptions& options, Job* job) {
  Array<std::uint8_t> grey = call(job, [&, options](Job& j) {
    BakeMap map;
    {
      const Job::Part mapping(j, "baking", 0.35, 0.4);
      map = bake_map(mesh, part, poly, atlas, options, j);
    }
    const Job::Part tracing(j, "occlusion", 0.4, 0.98);
    return occlusion(mesh, map, options, j);
  });
  return pixels(std::move(grey), atlas.side, 1);
}

constexpr double kLeastHeight = 1e-3;  // texels

py::tuple height_texture(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly, const Atlas& atlas,
                         const TextureOptions& options, Job* job) {
  HeightImage image = call(job, [&, options](Job& j) {
    const Job::Part mapping(j, "baking", options.occlusion ? 0.3 : 0.6, options.occlusion ? 0.35 : 0.98);
    return height_image(bake_map(mesh, part, poly, atlas, options, j), kLeastHeight / atlas.scale);
  });
  return py::make_tuple(pixels(std::move(image.grey), atlas.side, 1), image.range);
}

py::tuple map_texture(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly, const Atlas& atlas,
                      const TextureOptions& options, Job* job) {
  BakeMap map = call(job, [&, options](Job& j) { return bake_map(mesh, part, poly, atlas, options, j); });
  return py::make_tuple(pixels(std::move(map.polygon), map.side, 1), pixels(std::move(map.face), map.side, 1),
                        pixels(std::move(map.barycentric), map.side, 2), pixels(std::move(map.height), map.side, 1));
}

py::tuple places_of(const KeptMesh& mesh, const Partition& part, const PolygonMesh& poly,
                    const Contiguous<std::uint8_t>& known, std::int32_t threads, Job* job) {
  CornerPlaces found = call(job, [&](Job& j) { return closest_places(mesh, part, poly, span_of(known), threads, j); });
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
      .def_readonly("chart_count", &Atlas::chart_count)
      .def_property_readonly("chart", viewer<Atlas>(&Atlas::chart))
      .def_property_readonly("uv", &uv_of)
      .def_property_readonly("tangent", [](const Atlas& atlas) { return directions(atlas, &ChartFrame::u); })
      .def_property_readonly("normal", [](const Atlas& atlas) { return directions(atlas, &ChartFrame::n); });
  m.def(
      "_unwrap",
      [](const PolygonMesh& poly, const TextureOptions& o, double density, Job* job) {
        return call(job, [&, o](Job& j) {
          check_fields(o);
          return unwrap(poly, o.size.value_or(0), density, o.unfold, o.gutter.value_or(0), j);
        });
      },
      "polygons"_a, "options"_a, "density"_a, "job"_a = py::none());
  m.def("_bake", &bake_texture, "mesh"_a, "partition"_a, "polygons"_a, "atlas"_a, "uv"_a, "image"_a, "colors"_a,
        "known"_a, "pictures"_a, "layers"_a, "relief"_a, "options"_a, "job"_a = py::none());
  m.def("_bake_map", &map_texture, "mesh"_a, "partition"_a, "polygons"_a, "atlas"_a, "options"_a, "job"_a = py::none());
  m.def("_occlusion", &occlusion_texture, "mesh"_a, "partition"_a, "polygons"_a, "atlas"_a, "options"_a,
        "job"_a = py::none());
  m.def("_height", &height_texture, "mesh"_a, "partition"_a, "polygons"_a, "atlas"_a, "options"_a,
        "job"_a = py::none());
  m.def("_closest_places", &places_of, "mesh"_a, "partition"_a, "polygons"_a, "known"_a, "threads"_a = 0,
        "job"_a = py::none());
  m.def("_source_corners", &corners_of, "mesh"_a, "vertices"_a, "triangles"_a, "job"_a = py::none());
}

}  // namespace isimp::bindings
