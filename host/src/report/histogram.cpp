#include "histogram.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace cylpose {
namespace {

/// The smallest of 1, 2, 5, 10, 20 ... (times any power of ten) that is not below `least`.
double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (digit * power >= least) return digit * power;
  }
  return 10 * power;
}

}  // namespace

Histogram histogram_of(std::vector<double> values) {
  Histogram histogram;
  if (values.empty()) return histogram;
  std::sort(values.begin(), values.end());
  histogram.max = values.back();
  constexpr double kMostBins = 40;
  constexpr double kNothing = 1e-12;  // no error that small means anything, and its powers of ten may not exist
  const double p90 = values[(values.size() - 1) * 9 / 10];
  const double end = std::min(histogram.max, 4 * p90);
  if (end > kNothing) histogram.step = round_step(end / kMostBins);
  histogram.counts.resize(static_cast<std::size_t>(end / histogram.step) + 1);
  for (const double value : values) {
    const double bin = value / histogram.step;
    if (bin < static_cast<double>(histogram.counts.size())) {
      ++histogram.counts[static_cast<std::size_t>(bin)];
    } else {
      ++histogram.above;
    }
  }
  return histogram;
}

}  // namespace cylpose
