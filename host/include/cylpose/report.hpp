// A run as one HTML page that needs nothing else: summary, plots that zoom, pictures, and the numbers as JSON.
#pragma once

#include <cstdint>
#include <cylpose/html_page.hpp>
#include <cylpose/pose_io.hpp>
#include <cylpose/stage_table.hpp>
#include <string>
#include <vector>

namespace cylpose {

struct ReportPicture {
  std::string caption;
  std::vector<std::uint8_t> jpeg;
  int width = 0;  ///< pixels
  int height = 0;
};

/// From the frame being there to its poses being known.
struct FrameTime {
  std::int64_t frame = 0;
  double milliseconds = 0;
};

struct Report {
  std::string title;  ///< this and all other text may hold anything: it is escaped, bytes that are not UTF-8 replaced
  std::vector<ReportFact> facts;
  std::vector<PoseRow> poses;   ///< one per frame and part, in any order
  std::vector<TruthRow> truth;  ///< empty: nothing to compare with. Matched with the poses as evaluate() does
  std::vector<FrameTime> frame_times;
  std::vector<StageSummary> stages;
  std::vector<ReportPicture> pictures;
};

/// The page, valid HTML 5 in UTF-8: it asks the network for nothing (its content security policy forbids it), follows
/// the reader's light or dark colours and prints. `<script id="data" type="application/json">` holds the columns of the
/// poses, the truth and the errors, the numbers to the last digit (docs/report.md). A run of more than some 10,000 rows
/// is thinned out there, and the page says so; tables and histograms are of all rows. Poses with numbers that are not
/// finite are shown as not found, and the page says how many.
/// Throws Error(kInput) for rows given twice, and where it is unclear which part the truth belongs to.
[[nodiscard]] std::string to_html(const Report& report);

}  // namespace cylpose
