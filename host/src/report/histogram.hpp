// How often which value occurs, in bins of round width.
#pragma once

#include <cstdint>
#include <vector>

namespace cylpose {

struct Histogram {
  double step = 1;                   ///< bin i holds the values of [i * step, (i + 1) * step)
  std::vector<std::int64_t> counts;  ///< empty for no values
  std::int64_t above = 0;            ///< values beyond the last bin
  double max = 0;                    ///< the largest of all values
};

/// Bins of width 1, 2 or 5 times a power of ten from 0 to four times the 90th percentile or the maximum, whichever is
/// less: one far value must not press all others into one bin. Values are finite and not negative.
[[nodiscard]] Histogram histogram_of(std::vector<double> values);

}  // namespace cylpose
