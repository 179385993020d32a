// What a tile costs, learnt from what tiles cost, and from that which tiles are worth sending away.
#pragma once

#include <cstddef>
#include <cylpose/backend.hpp>
#include <vector>

namespace cylpose::cluster {

/// Time = fixed + per pixel, fitted by least squares to what was measured, newer measurements counting more.
class CostModel {
 public:
  /// One measurement. Pixels above 0.
  void add(double pixels, double ms);
  [[nodiscard]] bool known() const { return weight_ > 0; }
  /// What to expect; 0 while nothing is known. Never less than 0, and never falling with more pixels.
  [[nodiscard]] double ms(double pixels) const;

 private:
  double weight_ = 0;  ///< weighted sums over the measurements
  double pixels_ = 0;
  double ms_ = 0;
  double pixels_squared_ = 0;
  double pixels_ms_ = 0;
};

/// Somebody who takes tiles.
struct Offer {
  CostModel cost;  ///< of a tile, from sending it to having its result
  int slots = 0;   ///< tiles that it takes now
};

struct Assignment {
  Rows rows;
  std::size_t offer;
};

/// What stays here.
struct HomeCosts {
  CostModel local;    ///< of rows done by the local device
  CostModel sending;  ///< of getting a tile on its way, which the local device waits for
};

/// Which tiles, cut from the lower end of `height` rows, are done sooner elsewhere than here, with all working at the
/// same time; from the lowest up. The rows above are for the local device. Empty where it is quickest alone.
[[nodiscard]] std::vector<Assignment> worth_sending(int height, int width, int tile_rows, const HomeCosts& home,
                                                    const std::vector<Offer>& offers);

}  // namespace cylpose::cluster
