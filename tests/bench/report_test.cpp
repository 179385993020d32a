// What people see of a run: the table and the picture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <sstream>

#include "bench_files.hpp"
#include "case_grid.hpp"
#include "page.hpp"
#include "stage_picture.hpp"
#include "table.hpp"

namespace cylpose::bench {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

BenchRun small_run() {
  const nlohmann::json counters{{"frame_bytes", 3e6}, {"stage_ms/00/gate", 1.0}, {"stage_ms/01/edges", 0.5}};
  return testing::loaded({{"detect/serial/roi/640x400", {4000}, counters},
                          {"detect/serial/full/1280x720", {9000}, counters},
                          {"detect/serial/full/640x400", {6000}, counters},
                          {"detect/opencl/full/640x400", {1500, 2000, 9000}, counters},
                          {"overhead/opencl", {80}},
                          {"read_bandwidth/640x400", {7}, {{"GB/s", 100}}}});
}

std::vector<std::string> words_of_line(const std::string& text, const std::string& start) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    std::vector<std::string> all;
    while (words >> word) all.push_back(word);
    if (all.size() > 1 && all[0] + " " + all[1] == start) return all;
  }
  return {};
}

TEST(Report, GridPutsBackendsSideBySideAndSizesInOrder) {
  const BenchRun run = small_run();
  const CaseGrid grid = grid_of(run, "detect");
  EXPECT_THAT(grid.backends, ElementsAre("serial", "opencl"));
  ASSERT_EQ(grid.rows.size(), 3U);
  EXPECT_EQ(grid.rows[0].size, "640x400");
  EXPECT_EQ(grid.rows[0].by_backend[1], run.find("detect/opencl/full/640x400"));
  EXPECT_EQ(grid.rows[1].size, "1280x720");
  EXPECT_EQ(grid.rows[1].by_backend[1], nullptr);
  EXPECT_EQ(grid.rows[2].scene, "roi");
  EXPECT_TRUE(grid_of(run, "estimate").rows.empty());
}

TEST(Report, TableHasMediansRatiosAndTheTimeOfReading) {
  const std::string table = table_of(small_run());
  EXPECT_THAT(words_of_line(table, "detect median"),
              ElementsAre("detect", "median", "ms", "serial", "opencl", "reading", "serial/opencl"));
  EXPECT_THAT(words_of_line(table, "full 640x400"), ElementsAre("full", "640x400", "6.000", "2.000", "0.0300", "3.0"));
  EXPECT_THAT(words_of_line(table, "full 1280x720"), ElementsAre("full", "1280x720", "9.000", "-", "-", "-"));
  EXPECT_THAT(table, HasSubstr("gate 1.000 edges 0.500"));
  EXPECT_THAT(table, HasSubstr("abacus"));
  EXPECT_THAT(words_of_line(table, "overhead/opencl 0.0800"), ElementsAre("overhead/opencl", "0.0800", "-"));
}

TEST(Report, WithoutTheYardstickThereAreNoRatios) {
  const std::string table = table_of(testing::loaded({{"detect/serial/full/640x400", {6000}}}));
  EXPECT_THAT(table, HasSubstr("6.000"));
  EXPECT_THAT(table, Not(HasSubstr("/opencl")));
}

TEST(Report, PageHasTheTablesNumbersAndHarmlessTexts) {
  BenchRun run = small_run();
  run.context["processor"] = "<script>alert(1)</script>";
  const std::string page = page_of(run);
  EXPECT_THAT(page,
              HasSubstr("<th scope=\"row\">full 640x400</th><td>6.000</td><td>2.000</td><td>0.0300</td><td>3.0</td>"));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">full 1280x720</th><td>9.000</td><td>-</td><td>-</td><td>-</td>"));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">overhead/opencl</th><td>0.0800</td>"));
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
}

TEST(Report, PictureShowsStagesInTheShareOfTheirTime) {
  const cv::Mat picture = stage_picture(small_run());
  // Pixels of the colours of the two stages and of what lies between them: sums over all four bars.
  const auto pixels_of = [&](const cv::Scalar& color) {
    cv::Mat same;
    cv::inRange(picture, color, color, same);
    return static_cast<double>(cv::countNonZero(same));
  };
  const double gate = pixels_of({178, 114, 0});
  const double edges = pixels_of({0, 159, 230});
  const double rest = pixels_of({205, 205, 205});
  EXPECT_GT(gate, 5000);
  EXPECT_NEAR(edges / gate, 0.5, 0.1);
  EXPECT_GT(rest, gate);
}

TEST(Report, PictureOfARunWithoutStagesIsEmptyNotAnError) {
  EXPECT_FALSE(stage_picture(testing::loaded({{"overhead/opencl", {80}}})).empty());
}

}  // namespace
}  // namespace cylpose::bench
