#include <gmock/gmock.h>

#include <cmath>
#include <cylpose/error.hpp>
#include <cylpose/report.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

#include "temp_dir.hpp"

namespace cylpose {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kHostile = "</script><script>alert(1)</script><!--\"'&\xFF\x01{{data}}";

CylinderPose pose_at(double x) {
  return {{x, 0.1, 2}, Eigen::Vector3d(0.1, -1, 0.2).normalized()};
}

PoseRow ok_row(std::int64_t frame, const std::string& part = "can") {
  PoseRow row;
  row.frame = frame;
  row.timestamp_s = static_cast<double>(frame) / 30;
  row.part = part;
  row.status = PoseStatus::kOk;
  row.pose = pose_at(0.01 * static_cast<double>(frame));
  row.sigma_center_m = {0.001, 0.002, 0.003};
  row.sigma_axis_deg = 0.25;
  row.rms_px = 0.125;
  return row;
}

PoseRow none_row(std::int64_t frame, const std::string& reason) {
  PoseRow row;
  row.frame = frame;
  row.part = "can";
  row.reason = reason;
  return row;
}

Report report_of(std::vector<PoseRow> poses, std::vector<TruthRow> truth = {}) {
  Report report;
  report.title = "title";
  report.poses = std::move(poses);
  report.truth = std::move(truth);
  return report;
}

std::string between(const std::string& text, const std::string& open, const std::string& close) {
  const std::size_t start = text.find(open);
  EXPECT_NE(start, std::string::npos) << open;
  if (start == std::string::npos) return {};
  return text.substr(start + open.size(), text.find(close, start) - start - open.size());
}

json data_of(const std::string& page) {
  return json::parse(between(page, "<script id=\"data\" type=\"application/json\">", "</script>"));
}

/// The cell in the first column of the summary's row with this label.
std::string summary_cell(const std::string& page, const std::string& label) {
  return between(page, "<th scope=\"row\">" + label + "</th><td>", "</td>");
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::string refusal(const Report& report) {
  try {
    (void)to_html(report);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    return error.what();
  }
  ADD_FAILURE() << "was accepted";
  return {};
}

TEST(Report, HoldsTheNumbersOfTheCsvToTheLastDigit) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<PoseRow> rows;
  std::vector<TruthRow> truth;
  for (int i = 0; i < 50; ++i) {
    PoseRow row = ok_row(i);
    row.timestamp_s = normal(random);
    row.pose = {{normal(random), normal(random), normal(random)},
                Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized()};
    row.sigma_center_m = Eigen::Vector3d(normal(random), normal(random), normal(random)).cwiseAbs();
    row.sigma_axis_deg = std::abs(normal(random));
    row.rms_px = std::abs(normal(random));
    rows.push_back(row);
    truth.push_back({i, "", {row.pose.center_in_cam * 1.001, row.pose.axis_in_cam}});
  }
  const json data = data_of(to_html(report_of(rows, truth)));
  const json& part = data.at("parts").at(0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(data["frame"][i], rows[i].frame);
    EXPECT_EQ(data["timestamp_s"][i].get<double>(), rows[i].timestamp_s);
    EXPECT_EQ(part["status"][i], "ok");
    for (int k = 0; k < 3; ++k) {
      const std::string axis(1, "xyz"[k]);
      EXPECT_EQ(part["c" + axis][i].get<double>(), rows[i].pose.center_in_cam[k]);
      EXPECT_EQ(part["a" + axis][i].get<double>(), rows[i].pose.axis_in_cam[k]);
      EXPECT_EQ(part["sigma_c" + axis][i].get<double>(), rows[i].sigma_center_m[k]);
      EXPECT_EQ(part["truth"]["c" + axis][i].get<double>(), truth[i].pose.center_in_cam[k]);
      EXPECT_EQ(part["truth"]["a" + axis][i].get<double>(), truth[i].pose.axis_in_cam[k]);
    }
    EXPECT_EQ(part["sigma_axis_deg"][i].get<double>(), rows[i].sigma_axis_deg);
    EXPECT_EQ(part["rms_px"][i].get<double>(), rows[i].rms_px);
    const PoseError error = pose_error(rows[i].pose, truth[i].pose);
    EXPECT_NEAR(part["error"]["depth_m"][i].get<double>(), error.depth_m, 1e-5 * error.depth_m);
    EXPECT_NEAR(part["error"]["lateral_m"][i].get<double>(), error.lateral_m, 1e-5 * error.lateral_m);
    EXPECT_NEAR(part["error"]["along_axis_m"][i].get<double>(), error.along_axis_m, 1e-5 * error.along_axis_m);
  }
}

TEST(Report, TextCannotBecomeMarkupOrLeaveItsPlace) {
  Report report = report_of({ok_row(0, kHostile), ok_row(1, kHostile)});
  report.title = kHostile;
  report.facts = {{kHostile, kHostile}};
  PoseRow none = none_row(2, kHostile);
  none.part = kHostile;
  report.poses.push_back(none);
  report.stages = {{kHostile, {1, 1, 1, 1}, 1}};
  report.pictures = {{kHostile, {1, 2, 3}, 4, 3}};
  const std::string page = to_html(report);
  const std::string plain = to_html(report_of({ok_row(0)}));
  for (const char* tag : {"<script", "</script", "<!--"}) EXPECT_EQ(count_of(page, tag), count_of(plain, tag)) << tag;
  EXPECT_THAT(page, Not(HasSubstr("alert(1)</script>")));
  EXPECT_THAT(page,
              HasSubstr("&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;!--&quot;'&amp;\uFFFD\uFFFD{{data}}"));
  EXPECT_EQ(page.find('\xFF'), std::string::npos) << "bytes that are not UTF-8 are replaced";
  EXPECT_EQ(page.find('\x01'), std::string::npos);
  EXPECT_EQ(data_of(page)["parts"][0]["name"], "</script><script>alert(1)</script><!--\"'&\uFFFD\x01{{data}}");
}

TEST(Report, NoneRowsAreGapsWithTheirReasonCounted) {
  const std::string page = to_html(
      report_of({ok_row(0), none_row(1, "one side only"), none_row(2, "one side only"), none_row(3, "no edge")}));
  const json part = data_of(page)["parts"][0];
  EXPECT_EQ(part["status"], json({"ok", "none", "none", "none"}));
  EXPECT_TRUE(part["cx"][1].is_null());
  EXPECT_TRUE(part["rms_px"][3].is_null());
  EXPECT_EQ(summary_cell(page, "Found"), "1 (25.0 %)");
  EXPECT_EQ(summary_cell(page, "None"), "3");
  EXPECT_THAT(page, HasSubstr("<td class=\"text\">one side only</td><td>2</td>"));
}

TEST(Report, NumbersThatAreNotFiniteCountAsNoneAndAreReported) {
  PoseRow bad = ok_row(1);
  bad.pose.center_in_cam.z() = kNan;
  PoseRow infinite = ok_row(2);
  infinite.sigma_axis_deg = std::numeric_limits<double>::infinity();
  const std::string page = to_html(report_of({ok_row(0), bad, infinite}, {{1, "", pose_at(0)}}));
  const json data = data_of(page);
  EXPECT_EQ(data["parts"][0]["status"], json({"ok", "none", "none"}));
  EXPECT_TRUE(data["parts"][0]["cx"][1].is_null());
  EXPECT_THAT(page, HasSubstr("2 poses hold numbers that are not finite"));
}

TEST(Report, ARunWithoutRowsIsAPageThatSaysSo) {
  const std::string page = to_html(report_of({}));
  EXPECT_THAT(page, HasSubstr("The run has no frames."));
  EXPECT_THAT(data_of(page)["frame"], testing::IsEmpty());
}

TEST(Report, OneFrameIsEnough) {
  const json data = data_of(to_html(report_of({ok_row(7)}, {{7, "", pose_at(0.07)}})));
  EXPECT_EQ(data["frame"], json({7}));
  for (const json& histogram : data["parts"][0]["histograms"]) {
    EXPECT_EQ(histogram["counts"].back().get<int>() + histogram["above"].get<int>(), 1) << histogram;
  }
}

TEST(Report, PartsShareTheFramesAndGapsAreMissing) {
  const std::string page = to_html(report_of({ok_row(0, "a"), ok_row(2, "b"), ok_row(2, "a")}));
  const json data = data_of(page);
  EXPECT_EQ(data["frame"], json({0, 2}));
  EXPECT_EQ(data["parts"][0]["name"], "a");
  EXPECT_EQ(data["parts"][1]["status"], json({nullptr, "ok"}));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">Missing</th><td>0</td><td>1</td>"));
  EXPECT_EQ(count_of(page, "<div class=\"charts\" data-part="), 2U);
}

TEST(Report, TheSummaryIsTheEvaluations) {
  std::vector<TruthRow> truth;
  for (int i = 0; i < 3; ++i) truth.push_back({i, "can", pose_at(0.01 * i + 0.004)});
  const std::string page = to_html(report_of({ok_row(0), ok_row(1), none_row(2, "dark")}, truth));
  EXPECT_EQ(summary_cell(page, "Centre error, median [mm]"), "4.000");
  EXPECT_EQ(summary_cell(page, "Wrong: axis off by more than 10°"), "0");
  // An x error of 4 mm is outside of two sigmas of 1 mm; y and z are right.
  EXPECT_THAT(page, HasSubstr("x 0.0 %, y 100.0 %, z 100.0 % of the found centres"));
}

TEST(Report, ALongRunIsThinnedOutToWhatStandsOut) {
  std::vector<PoseRow> rows;
  std::vector<TruthRow> truth;
  for (int i = 0; i < 40000; ++i) {
    rows.push_back(ok_row(i));
    truth.push_back({i, "", rows.back().pose});
  }
  rows[20001].pose.center_in_cam.z() += 0.5;
  rows[30002] = none_row(30002, "dark");
  const std::string page = to_html(report_of(rows, truth));
  const json data = data_of(page);
  EXPECT_LT(page.size(), 5'000'000U);
  EXPECT_EQ(data["frames_in_all"], 40000);
  EXPECT_EQ(data["frame"].size(), 10000U);
  const auto has = [&](int frame) {
    return std::find(data["frame"].begin(), data["frame"].end(), frame) != data["frame"].end();
  };
  EXPECT_TRUE(has(20001));
  EXPECT_TRUE(has(30002));
  EXPECT_EQ(summary_cell(page, "Found"), "39999 (100.0 %)") << "tables are of all frames";
  std::int64_t counted = 0;
  const json& histogram = data["parts"][0]["histograms"].back();
  for (const json& count : histogram["counts"]) counted += count.get<std::int64_t>();
  EXPECT_EQ(counted + histogram["above"].get<std::int64_t>(), 39999) << "so are histograms";
}

TEST(Report, TenThousandFramesWithTruthStayWhole) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<PoseRow> rows;
  std::vector<TruthRow> truth;
  Report report;
  for (int i = 0; i < 10000; ++i) {
    PoseRow row = ok_row(i);
    const auto vector = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
    row.pose = {vector() * 1e-3, vector().normalized()};  // long numbers
    row.sigma_center_m = vector().cwiseAbs() * 1e-5;
    row.sigma_axis_deg = row.rms_px = std::abs(normal(random)) * 1e-3;
    report.poses.push_back(row);
    report.truth.push_back({i, "", {vector() * 1e-3, vector().normalized()}});
    report.frame_times.push_back({i, 3.14159});
  }
  const std::string page = to_html(report);
  EXPECT_EQ(data_of(page)["frame"].size(), 10000U);
  EXPECT_LT(page.size(), 5'000'000U - 400'000U) << "pictures need room as well";
}

TEST(Report, AsksForNothingAndCarriesTheLicence) {
  const std::string page = to_html(report_of({ok_row(0)}));
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy\" content=\"default-src 'none'"));
  EXPECT_THAT(page, HasSubstr("Permission is hereby granted, free of charge"));
  EXPECT_THAT(page, Not(HasSubstr("sourceMappingURL")));
  EXPECT_FALSE(std::regex_search(page.substr(0, page.find("<script")), std::regex("(src|href)=\"(?!data:|#)")));
  EXPECT_FALSE(std::regex_search(page, std::regex("\\{\\{[a-z_]+\\}\\}"))) << "every field was filled";
}

TEST(Report, RefusesRowsGivenTwiceAndTruthOfAnUnclearPart) {
  EXPECT_THAT(refusal(report_of({ok_row(3), ok_row(3)})), AllOf(HasSubstr("frame 3, part can"), HasSubstr("poses")));
  EXPECT_THAT(refusal(report_of({ok_row(3)}, {{3, "", pose_at(0)}, {3, "", pose_at(0)}})), HasSubstr("in the truth"));
  EXPECT_THAT(refusal(report_of({ok_row(0, "a"), ok_row(0, "b")}, {{0, "", pose_at(0)}})), HasSubstr("column 'part'"));
}

}  // namespace
}  // namespace cylpose
