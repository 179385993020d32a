// Reports as the command writes them; tests/report looks at them in a browser.
#include <gmock/gmock.h>

#include <cylpose/pose_io.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "scene.hpp"

namespace cylpose {
namespace {

using testing::HasSubstr;
using ReportCommand = SceneTest;

nlohmann::json data_of(const std::string& page) {
  const std::string open = "<script id=\"data\" type=\"application/json\">";
  const std::size_t start = page.find(open) + open.size();
  return nlohmann::json::parse(page.substr(start, page.find("</script>", start) - start));
}

std::string truth_of_frames(int count) {
  std::ostringstream text;
  text.precision(17);
  text << "frame,cx,cy,cz,ax,ay,az\n";
  for (int i = 0; i < count; ++i) {
    const CylinderPose pose = pose_of_frame(i);
    text << i;
    for (const double number : pose.center_in_cam) text << ',' << number;
    for (const double number : pose.axis_in_cam) text << ',' << number;
    text << '\n';
  }
  return text.str();
}

TEST_F(ReportCommand, OfEstimateHoldsTheRowsTimesAndPictures) {
  write_frames(3);
  const CommandResult result = estimate({"--output", path("poses.csv"), "--report", path("report.html"), "--truth",
                                         file("truth.csv", truth_of_frames(3)), path("frames")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string page = text_of(path("report.html"));
  const nlohmann::json data = data_of(page);
  const std::vector<PoseRow> rows = load_poses(path("poses.csv"));
  ASSERT_EQ(data["frame"].size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(data["parts"][0]["cz"][i].get<double>(), rows[i].pose.center_in_cam.z());
    EXPECT_EQ(data["parts"][0]["rms_px"][i].get<double>(), rows[i].rms_px);
    EXPECT_EQ(data["parts"][0]["sigma_axis_deg"][i].get<double>(), rows[i].sigma_axis_deg);
    EXPECT_LT(data["parts"][0]["error"]["depth_m"][i].get<double>(), 0.03);
    EXPECT_GT(data["frame_ms"][i].get<double>(), 0);
  }
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">decode</th>"));
  EXPECT_THAT(page, HasSubstr("<img src=\"data:image/jpeg;base64,/9j/"));
  EXPECT_THAT(page, HasSubstr("Best: frame "));
}

TEST_F(ReportCommand, OfEvaluateHoldsOnePartWhenAskedTo) {
  write_frames(2);
  ASSERT_EQ(estimate({"--output", path("poses.csv"), path("frames")}).exit_code, 0);
  const std::string truth = file("truth.csv", truth_of_frames(2));
  const CommandResult result =
      run({"evaluate", truth, path("poses.csv"), "--part", "can", "--report", path("report.html")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("found      2 of 2"));
  const nlohmann::json data = data_of(text_of(path("report.html")));
  EXPECT_EQ(data["parts"].size(), 1U);
  EXPECT_EQ(data["parts"][0]["truth"]["cx"].size(), 2U);
}

TEST_F(ReportCommand, AnImpossibleReportIsRefusedBeforeTheRun) {
  write_frames(1);
  const CommandResult nowhere =
      estimate({"--output", path("poses.csv"), "--report", path("nowhere/report.html"), path("frames")});
  EXPECT_EQ(nowhere.exit_code, 3);
  EXPECT_THAT(nowhere.err, HasSubstr("nowhere/report.html"));
  EXPECT_FALSE(std::filesystem::exists(path("poses.csv")));
  EXPECT_EQ(estimate({"--report", "-", path("frames")}).exit_code, 2) << "poses and page cannot share standard output";
  EXPECT_EQ(estimate({"--truth", file("truth.csv", truth_of_frames(1)), path("frames")}).exit_code, 2)
      << "truth without a report would be ignored";
}

}  // namespace
}  // namespace cylpose
