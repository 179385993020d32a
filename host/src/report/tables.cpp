#include "tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cylpose/html_page.hpp>
#include <map>
#include <utility>

namespace cylpose {
namespace {

struct Counts {
  std::size_t ok = 0, predicted = 0, none = 0, missing = 0;
};

Counts counts_of(const PartSeries& part) {
  Counts counts;
  for (const auto& row : part.poses) {
    if (!row) {
      ++counts.missing;
    } else if (row->status == PoseStatus::kOk) {
      ++counts.ok;
    } else if (row->status == PoseStatus::kPredicted) {
      ++counts.predicted;
    } else {
      ++counts.none;
    }
  }
  return counts;
}

template <typename Value>
std::vector<double> of_ok_rows(const PartSeries& part, const Value& value) {
  std::vector<double> values;
  for (const auto& row : part.poses) {
    if (row && row->status == PoseStatus::kOk) values.push_back(value(*row));
  }
  return values;
}

std::string share(std::size_t count, std::size_t all) {
  return all == 0 ? "0"
                  : fmt::format("{} ({:.1f} %)", count, 100 * static_cast<double>(count) / static_cast<double>(all));
}

/// Four digits that say something, without an exponent.
std::string number(double value) {
  const double size = std::abs(value);
  const int decimals = size < 1e-4 ? 4 : std::clamp(3 - static_cast<int>(std::floor(std::log10(size))), 0, 4);
  return fmt::format("{:.{}f}", value, decimals);
}

std::string statistics_row(const std::string& label, const std::optional<Statistics>& statistics, double factor) {
  std::string row = fmt::format("<tr><th scope=\"row\">{}</th>", label);
  if (!statistics) return row + "<td>–</td><td>–</td><td>–</td><td>–</td></tr>\n";
  for (const double value : {statistics->median, statistics->mean, statistics->p95, statistics->max}) {
    row += fmt::format("<td>{}</td>", number(factor * value));
  }
  return row + "</tr>\n";
}

/// How many errors lie within two stated standard deviations; 95 % should.
std::string honesty(const PartSeries& part) {
  std::size_t compared = 0;
  Eigen::Vector3i within = Eigen::Vector3i::Zero();
  for (std::size_t i = 0; i < part.poses.size(); ++i) {
    if (!part.errors[i]) continue;
    ++compared;
    const Eigen::Vector3d error = part.poses[i]->pose.center_in_cam - part.truth[i]->center_in_cam;
    within += (error.cwiseAbs().array() <= 2 * part.poses[i]->sigma_center_m.array()).matrix().cast<int>();
  }
  if (compared == 0) return {};
  const auto percent = [&](int count) { return 100.0 * count / static_cast<double>(compared); };
  return fmt::format(
      "<p>Within two stated standard deviations of the truth: x {:.1f} %, y {:.1f} %, z {:.1f} % of the found centres; "
      "95.4 % are to be expected.</p>\n",
      percent(within.x()), percent(within.y()), percent(within.z()));
}

std::string reasons(const PartSeries& part) {
  std::map<std::string, std::size_t> by_reason;
  for (const auto& row : part.poses) {
    if (row && row->status == PoseStatus::kNone && !row->reason.empty()) ++by_reason[row->reason];
  }
  if (by_reason.empty()) return {};
  std::vector<std::pair<std::string, std::size_t>> sorted(by_reason.begin(), by_reason.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  constexpr std::size_t kMost = 8;
  std::string body;
  for (std::size_t i = 0; i < std::min(sorted.size(), kMost); ++i) {
    body += fmt::format("<tr><td class=\"text\">{}</td><td>{}</td></tr>\n", html_escaped(sorted[i].first),
                        sorted[i].second);
  }
  if (sorted.size() > kMost) {
    body += fmt::format("<tr><td class=\"text\">{} more reasons</td><td></td></tr>\n", sorted.size() - kMost);
  }
  return html_table("Why no pose was given", "<tr><th scope=\"col\">Reason</th><th scope=\"col\">Frames</th></tr>\n",
                    body);
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8U | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63U];
  }
  return text;
}

}  // namespace

std::string summary_html(const RunSeries& run) {
  if (run.parts.empty()) return "<p>The run has no frames.</p>\n";
  std::string head = "<tr><td></td>";
  for (const PartSeries& part : run.parts) head += fmt::format("<th scope=\"col\">{}</th>", html_escaped(part.name));
  head += "</tr>\n";
  std::string body;
  const auto row = [&](const char* label, const auto& cell) {
    body += fmt::format("<tr><th scope=\"row\">{}</th>", label);
    for (const PartSeries& part : run.parts) body += fmt::format("<td>{}</td>", cell(part));
    body += "</tr>\n";
  };
  const auto median = [](const std::optional<Statistics>& statistics, double factor) {
    return statistics ? number(factor * statistics->median) : std::string("–");
  };
  const std::size_t frames = run.frames.size();
  row("Frames", [&](const PartSeries&) { return fmt::format("{}", frames); });
  row("Found", [&](const PartSeries& part) { return share(counts_of(part).ok, frames); });
  row("Predicted", [&](const PartSeries& part) { return fmt::format("{}", counts_of(part).predicted); });
  row("None", [&](const PartSeries& part) { return fmt::format("{}", counts_of(part).none); });
  row("Missing", [&](const PartSeries& part) { return fmt::format("{}", counts_of(part).missing); });
  row("Residual, median [px]", [&](const PartSeries& part) {
    return median(statistics_of(of_ok_rows(part, [](const PoseRow& r) { return r.rms_px; })), 1);
  });
  if (std::any_of(run.parts.begin(), run.parts.end(), [](const PartSeries& part) { return part.evaluation; })) {
    const auto of_evaluation = [](const PartSeries& part, const auto& cell) {
      return part.evaluation ? cell(*part.evaluation) : std::string("–");
    };
    row("Centre error, median [mm]", [&](const PartSeries& part) {
      return of_evaluation(part, [&](const Evaluation& e) { return median(e.position_m, kMillimetres); });
    });
    row("Axis error, median [deg]", [&](const PartSeries& part) {
      return of_evaluation(part, [&](const Evaluation& e) { return median(e.axis_angle_deg, 1); });
    });
    row("Wrong: axis off by more than 10°", [&](const PartSeries& part) {
      return of_evaluation(part, [&](const Evaluation& e) { return fmt::format("{}", e.wrong); });
    });
  }
  std::string html = html_table("Frames, residuals and errors of each part", head, body);
  if (run.not_finite > 0) {
    html += fmt::format("<p class=\"warning\">{} poses hold numbers that are not finite; they count as none.</p>\n",
                        run.not_finite);
  }
  return html;
}

std::string part_html(const PartSeries& part) {
  const auto sigma = [&](int axis) {
    return statistics_of(of_ok_rows(part, [axis](const PoseRow& row) { return row.sigma_center_m[axis]; }));
  };
  std::string body;
  if (part.evaluation) {
    const Evaluation& evaluation = *part.evaluation;
    body += statistics_row("Centre error [mm]", evaluation.position_m, kMillimetres);
    body += statistics_row("– depth [mm]", evaluation.depth_m, kMillimetres);
    body += statistics_row("– lateral [mm]", evaluation.lateral_m, kMillimetres);
    body += statistics_row("– along the axis [mm]", evaluation.along_axis_m, kMillimetres);
    body += statistics_row("Axis line distance [mm]", evaluation.axis_line_m, kMillimetres);
    body += statistics_row("Axis angle [deg]", evaluation.axis_angle_deg, 1);
  }
  body +=
      statistics_row("Residual, rms [px]", statistics_of(of_ok_rows(part, [](const auto& r) { return r.rms_px; })), 1);
  body += statistics_row("Stated σ of x [mm]", sigma(0), kMillimetres);
  body += statistics_row("Stated σ of y [mm]", sigma(1), kMillimetres);
  body += statistics_row("Stated σ of z [mm]", sigma(2), kMillimetres);
  body += statistics_row("Stated σ of the axis [deg]",
                         statistics_of(of_ok_rows(part, [](const auto& r) { return r.sigma_axis_deg; })), 1);
  const std::string head =
      "<tr><td></td><th scope=\"col\">median</th><th scope=\"col\">mean</th><th scope=\"col\">p95</th>"
      "<th scope=\"col\">max</th></tr>\n";
  return html_table("Errors, residuals and stated uncertainty of the found poses", head, body) + honesty(part) +
         reasons(part);
}

std::string stages_html(const std::vector<StageSummary>& stages) {
  if (stages.empty()) return {};
  double longest = 0;
  for (const StageSummary& stage : stages) longest = std::max(longest, stage.milliseconds.median);
  std::string body;
  for (const StageSummary& stage : stages) {
    const double width = longest > 0 ? 100 * stage.milliseconds.median / longest : 0;
    body += fmt::format(
        "<tr><th scope=\"row\">{}</th><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{}</td>"
        "<td class=\"bar\" aria-hidden=\"true\"><div style=\"width:{:.1f}%\"></div></td></tr>\n",
        html_escaped(stage.stage), stage.milliseconds.median, stage.milliseconds.mean, stage.milliseconds.p95,
        stage.frames, width);
  }
  return html_table("Milliseconds per frame",
                    "<tr><th scope=\"col\">Stage</th><th scope=\"col\">median</th><th scope=\"col\">mean</th>"
                    "<th scope=\"col\">p95</th><th scope=\"col\">frames</th><td></td></tr>\n",
                    body);
}

std::string pictures_html(const std::vector<ReportPicture>& pictures) {
  std::string html;
  for (const ReportPicture& picture : pictures) {
    const std::string caption = html_escaped(picture.caption);
    html += fmt::format(
        "<figure>\n<img src=\"data:image/jpeg;base64,{}\" width=\"{}\" height=\"{}\" alt=\"Overlay: {}\">\n"
        "<figcaption>{}</figcaption>\n</figure>\n",
        base64(picture.jpeg), picture.width, picture.height, caption, caption);
  }
  return html;
}

}  // namespace cylpose
