// Where the border runs, to a fraction of a pixel: the second half of edge detection, shared by all backends.
#pragma once

#include <cylpose/camera.hpp>
#include <cylpose/edge_field.hpp>
#include <cylpose/gate.hpp>
#include <cylpose/image.hpp>
#include <vector>

namespace cylpose {

/// Farther than this from the edge pixel's centre, in pixels along the gradient, no border is looked for.
inline constexpr double kLocateReach = 3.5;

/// Sets `offset_256` and `cue` of all edge pixels of one part.
///
/// In linear light a border pixel is a*c + b*B: the part's colour direction c, more or less brightly lit, and the
/// colour B outside. A channel w with w.c = 0 tells the outside's share b, whatever the shading: its profile along the
/// row or column of pixels nearest to the normal, averaged with the ones on either side, is a blurred step. The border
/// is where an even filter of seven weights sums up to zero on it; a symmetric blur does not move that place. c is the
/// mean over the inner sides of all edges, B is taken 5 to 8 pixels outside each edge.
///
/// Where there is no such channel (grey image; B black, or of the part's own hue) or it puts the border out of reach,
/// the part's own light along c is asked, and where B is not even, the channel in which B is zero however bright it is.
/// Toward the border that light falls off by shading, and not in a known way: another filter is zero on the border for
/// a step, for a falloff by the square root of the depth, and for anything between. Its bias is a few hundredths of a
/// pixel; it grows where fewer than 20 px lie between border and axis, and with a blur above 1 px. Where it has no
/// zero near the largest slope, or a terminator lies near the border, the largest slope is taken; where light does not
/// rise inward, the offset is 0.
///
/// Integers throughout. Pixels outside `search` do not exist; samples beyond its edge repeat the nearest pixel.
void locate_edges(const ImageView& image, const Roi& search, const ColorGate& gate, Transfer transfer,
                  std::vector<EdgePixel>& edges);

}  // namespace cylpose
