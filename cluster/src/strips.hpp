// Strips of a frame and how they become its edge field again.
#pragma once

#include <cylpose/backend.hpp>
#include <vector>

namespace cylpose::cluster {

/// What must be searched for the rows of `search`: those and their halo, in frame coordinates.
[[nodiscard]] Roi with_halo(const Roi& search, const Rows& rows);

/// The pixels of `roi` alone, as an image.
[[nodiscard]] ImageView cropped(const ImageView& image, const Roi& roi);

/// Regions and edges of the rows, offsets 0, in frame coordinates.
[[nodiscard]] std::vector<PartEdges> detect_strip(Backend& backend, const ImageView& image, const Roi& search,
                                                  const Rows& rows, std::span<const PartModel> parts,
                                                  DetectOptions options);

/// From the coordinates of an image cut out at (x, y) to those of the frame.
void shift(PartEdges& part, int x, int y);

/// The strips come from top to bottom.
void append(std::vector<PartEdges>& frame, std::vector<PartEdges>&& strip);

}  // namespace cylpose::cluster
