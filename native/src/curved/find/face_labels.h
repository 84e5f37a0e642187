#pragma once

#include <functional>
#include <vector>

#include "find/find.h"
#include "fit/points.h"

namespace isimp::curved {

/// (n) by graph index: the surface that each face is on, kNone where on none. Begins with that of the face's point;
/// faces at borders then move to the surface that fits them best. Only where no crease lies between may a face take the
/// label of a neighbour: else rims would turn into zigzag.
/// Cost: O(F), and for faces at borders some sweeps.
Some face_labels(const Faces& faces, const Points& points, const std::vector<Found>& found, const Nearness& near,
                 Job& job);

/// The misfit of a face to a label.
using Misfit = std::function<double(std::int32_t face, std::int32_t label)>;

/// Parts of a label that are not its largest and are small become part of the neighbour with the longest border, or of
/// that which they fit best.
/// \param labels  (n) by graph index, at least kNone
/// \param small   the area below which a part of a label is small, as a share of the whole surface's
/// \param misfit  of a face to a neighbour's label; null: the longest border counts
/// \param takes   whether a label may get faces of others
void absorb_fragments(const Faces& faces, Some& labels, const std::function<double(std::int32_t)>& small,
                      const Misfit& misfit, const std::function<bool(std::int32_t)>& takes, Job& job);

/// The parts of equal label: their numbers by graph index, from 0 on by first face.
struct LabelParts {
  Some part;                 ///< (n) by graph index
  Some label;                ///< (parts)
  std::vector<double> area;  ///< (parts)
};
LabelParts parts_of_labels(const Faces& faces, const Some& labels, Job& job);

/// The surfaces that are kept, so that free-form parts stay as they are: flat planes; a curved patch with most of its
/// border at creases, planes, other kept patches or the border of the scan; a full turn, or all of a sphere, with
/// a quarter of its border there. (gates.cpp)
std::vector<bool> kept_surfaces(const Faces& faces, const Points& points, const std::vector<Found>& found,
                                const Some& labels, const Nearness& near);

}  // namespace isimp::curved
