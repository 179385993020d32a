#include "cost_model.hpp"

#include <algorithm>

namespace cylpose::cluster {

void CostModel::add(double pixels, double ms) {
  constexpr double kMemory = 0.9;  // of what was known, per measurement
  const auto take = [](double& sum, double value) { sum = kMemory * sum + value; };
  take(weight_, 1);
  take(pixels_, pixels);
  take(ms_, ms);
  take(pixels_squared_, pixels * pixels);
  take(pixels_ms_, pixels * ms);
}

double CostModel::ms(double pixels) const {
  if (!known()) return 0;
  const double mean_pixels = pixels_ / weight_;
  const double mean_ms = ms_ / weight_;
  const double variance = pixels_squared_ / weight_ - mean_pixels * mean_pixels;
  constexpr double kLeastSpread = 0.1;  // of the mean: with less, half of the time is taken to be fixed
  double per_pixel = mean_ms / mean_pixels / 2;
  if (variance > kLeastSpread * kLeastSpread * mean_pixels * mean_pixels) {
    const double slope = (pixels_ms_ / weight_ - mean_pixels * mean_ms) / variance;
    per_pixel = std::clamp(slope, 0.0, mean_ms / mean_pixels);  // neither part of the time is negative
  }
  return std::max(0.0, mean_ms + per_pixel * (pixels - mean_pixels));
}

std::vector<Assignment> worth_sending(int height, int width, int tile_rows, const HomeCosts& home,
                                      const std::vector<Offer>& offers) {
  constexpr double kWorth = 0.9;  // what is saved must be more than measurements err
  std::vector<Assignment> plan;
  if (!home.local.known()) return plan;
  std::vector<double> ready(offers.size());
  std::vector<int> slots;
  slots.reserve(offers.size());
  for (const Offer& offer : offers) slots.push_back(offer.cost.known() ? offer.slots : 0);
  const auto local_ms = [&](int rows) { return rows == 0 ? 0 : home.local.ms(static_cast<double>(rows) * width); };

  double sending = 0;
  double finished_elsewhere = 0;
  double finished = local_ms(height);
  for (int rest = height; rest > 0;) {
    const int rows = std::min(tile_rows, rest);
    const double pixels = static_cast<double>(rows) * width;
    const double sent = sending + home.sending.ms(pixels);
    std::size_t best = offers.size();
    double soonest = 0;
    for (std::size_t i = 0; i < offers.size(); ++i) {
      if (slots[i] == 0) continue;
      const double done = std::max(ready[i], sending) + offers[i].cost.ms(pixels);
      if (best == offers.size() || done < soonest) {
        best = i;
        soonest = done;
      }
    }
    if (best == offers.size()) break;
    const double now = std::max(finished_elsewhere, sending + local_ms(rest));
    const double then = std::max({finished_elsewhere, soonest, sent + local_ms(rest - rows)});
    if (then >= now) break;
    finished = then;
    plan.push_back({{rest - rows, rest}, best});
    ready[best] = soonest;
    --slots[best];
    sending = sent;
    finished_elsewhere = std::max(finished_elsewhere, soonest);
    rest -= rows;
  }
  return finished < kWorth * local_ms(height) ? plan : std::vector<Assignment>();
}

}  // namespace cylpose::cluster
