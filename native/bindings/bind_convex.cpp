// Convex parts of a solid.
#include "arrays.h"
#include "bindings.h"
#include "call.h"
#include "isimp/convex/convex_parts.h"

namespace isimp::bindings {

using namespace py::literals;

void bind_convex(py::module_& m) {
  m.def(
      "_convex_parts",
      [](const py::object& vertices, const py::object& loops, const py::object& loop_start, const py::object& region,
         const py::object& enclosed, double tolerance, std::int32_t parts, std::int32_t most_vertices, double thickness,
         Job* job) {
        const PolygonSoup soup = read_soup(vertices, loops, loop_start);
        const std::vector<std::int32_t> regions = read_indices(region, "region", "(Q,)");
        const std::vector<Vec3> points = read_points(enclosed, "enclose", "(N, 3)");
        const ConvexOptions options{
            .tolerance = tolerance, .parts = parts, .most_vertices = most_vertices, .thickness = thickness};
        auto found = call(job, [&](Job& j) { return convex_parts(soup, regions, points, options, j); });
        py::list made;
        for (ConvexPart& part : found)
          made.append(py::make_tuple(owned(std::move(part.vertices)), owned(std::move(part.triangles)), part.volume));
        return made;
      },
      "vertices"_a, "loops"_a, "loop_start"_a, "region"_a, "enclosed"_a, "tolerance"_a, "parts"_a, "most_vertices"_a,
      "thickness"_a, "job"_a = py::none(),
      R"(Convex parts of the solid that polygons bound, as (vertices, triangles, volume); see `convex_parts`.

region: (Q,) the region of each polygon, or (0,). enclosed: (N, 3) points that must be in a part. tolerance: 0 for half a
per cent of the diagonal. parts: 0 for any number. thickness: 0 for a solid. Raises InvalidInput or Cancelled.)");
}

}  // namespace isimp::bindings
