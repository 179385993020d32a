#include <gmock/gmock.h>

#include <cylpose/graph/pipeline.hpp>
#include <map>
#include <nlohmann/json.hpp>

#include "../host/temp_dir.hpp"
#include "stream.hpp"

namespace cylpose::graph {
namespace {

// One command a frame, as a device that measures would tell.
class MeasuringDevice final : public Backend {
 public:
  [[nodiscard]] std::string_view name() const override { return "measuring"; }
  [[nodiscard]] EdgeField detect(const ImageView& image, const Roi& search, std::span<const PartModel> parts,
                                 const DetectOptions& options) override {
    EdgeField field = serial_->detect(image, search, parts, options);
    field.times.push_back({"kernel", 0.000125, 0.0005});
    return field;
  }

 private:
  std::unique_ptr<Backend> serial_ = make_backend("serial");
};

TEST(Trace, OfAPipelineShowsFramesNodesAndDeviceCommands) {
  const TempDir folder;
  const std::filesystem::path file = folder.path() / "trace.json";
  constexpr int kFrames = 6;
  {
    PipelineOptions options;
    options.trace = std::make_shared<Trace>(file);
    Pipeline pipeline(
        testing::stream_camera(), testing::stream_parts(), std::make_unique<MeasuringDevice>(), [](const FramePtr&) {},
        options);
    for (int i = 0; i < kFrames; ++i) ASSERT_TRUE(pipeline.put(testing::good_frame(i)));
    pipeline.wait_for_all();
    options.trace->close();
  }
  const auto events = nlohmann::json::parse(text_of(file));
  std::map<std::string, int> count;
  std::map<int, double> busy_until;  // per row
  for (const auto& event : events) {
    if (event.at("ph") == "M") continue;
    EXPECT_EQ(event.at("ph"), "X");
    const auto name = event.at("name").get<std::string>();
    ++count[name];
    const int frame = event.at("args").at("frame");
    EXPECT_TRUE(frame >= 0 && frame < kFrames);
    EXPECT_GE(event.at("ts").get<double>(), 0);
    EXPECT_GE(event.at("dur").get<double>(), 0);
    if (name == "frame") {
      double& until = busy_until[event.at("tid").get<int>()];
      EXPECT_GE(event.at("ts").get<double>(), until) << "frames of one row overlap";
      until = event.at("ts").get<double>() + event.at("dur").get<double>();
    }
    if (name == "kernel") {
      EXPECT_DOUBLE_EQ(event.at("dur").get<double>(), 0.125);
    }
  }
  for (const char* name : {"frame", "detect", "device", "collect", "solve", "sink", "kernel"}) {
    EXPECT_EQ(count[name], kFrames) << name;
  }
}

TEST(Trace, ThatCannotBeWrittenIsAnError) {
  try {
    const Trace trace("/nowhere/trace.json");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kOutput);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("/nowhere/trace.json"));
  }
  Trace full("/dev/full");
  for (int i = 0; i < 1000; ++i) full.span("node", i, Clock::now(), Clock::now());
  EXPECT_THROW(full.close(), Error);
}

}  // namespace
}  // namespace cylpose::graph
