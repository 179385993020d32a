// Where the border runs, to a fraction of a pixel: the second half of edge detection, shared by all backends.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/gate.hpp>
#include <cylpose/image.hpp>
#include <vector>

namespace cylpose {

/// Farther than this from the edge pixel's centre, in pixels along the gradient, no border is looked for.
inline constexpr double kLocateReach = 2.5;

/// Sets `offset_256` of all edge pixels of one part.
///
/// In linear light a border pixel is a*c + b*B: the part's colour direction c, more or less brightly lit, and the
/// colour B outside. For w with w.c = 0 and w.B = 1, b = w.pixel is the share of the outside, whatever the shading, and
/// its sum over the row or column of pixels nearest to the normal says where the part ends; a symmetric blur does not
/// move it. c is the mean over the inner sides of all edges, B is taken 3 to 6 pixels outside each edge.
///
/// Where there is no such channel (grey image; B black, or of the part's own hue) or it puts the border out of
/// reach, the offset is that of the largest slope of the light along the normal; the limb's shading moves that place
/// inside by some 0.1 to 0.3 px. Where there is no slope either, the offset is 0.
///
/// Integers throughout. Pixels outside `search` do not exist; samples beyond its edge repeat the nearest pixel.
void locate_edges(const ImageView& image, const Roi& search, const ColorGate& gate, Transfer transfer,
                  std::vector<EdgePixel>& edges);

}  // namespace cylpose
