#include <gmock/gmock.h>

#include <cylpose/error.hpp>
#include <cylpose/frame_source.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "temp_dir.hpp"

namespace cylpose {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

/// A grey that tells images apart.
cv::Mat image_of(int level) {
  return {24, 32, CV_8UC3, cv::Scalar(level, level, 255 - level)};
}

class FrameFiles : public testing::Test {
 protected:
  std::string save(const std::string& name, const cv::Mat& image) {
    const fs::path file = folder_.path() / name;
    fs::create_directories(file.parent_path());
    EXPECT_TRUE(cv::imwrite(file.string(), image));
    return file.string();
  }

  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  static std::vector<Frame> all(const std::vector<std::string>& inputs, FrameSourceOptions options = {}) {
    const auto source = open_frames(inputs, options);
    std::vector<Frame> frames;
    while (auto frame = source->next()) frames.push_back(std::move(*frame));
    return frames;
  }

  static std::vector<std::string> names(const std::vector<Frame>& frames) {
    std::vector<std::string> result;
    for (const Frame& frame : frames) result.push_back(fs::path(frame.name).filename().string());
    return result;
  }

  static std::string refusal(const std::vector<std::string>& inputs, ErrorKind kind = ErrorKind::kInput) {
    try {
      (void)all(inputs);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind);
      return error.what();
    }
    ADD_FAILURE() << "was accepted";
    return {};
  }

  /// A video of `frames` frames of 10 per second; skips the test where OpenCV cannot write one.
  std::string video(int frames) {
    const std::string file = path("clip.avi");
    cv::VideoWriter writer(file, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10, {64, 48});
    for (int i = 0; i < frames; ++i) {
      cv::Mat image(48, 64, CV_8UC3);
      cv::randu(image, 0, 255);  // so that every frame takes its bytes
      writer.write(image);
    }
    return file;
  }

  TempDir folder_;
};

TEST_F(FrameFiles, AFolderComesInNaturalOrderAndOnlyItsImages) {
  for (const int number : {10, 9, 100, 1}) save("f/frame_" + std::to_string(number) + ".png", image_of(number));
  folder_.write("f/truth.csv", "frame\n");
  fs::create_directories(folder_.path() / "f" / "sub.png");
  const std::vector<Frame> frames = all({path("f")});
  EXPECT_THAT(names(frames), ElementsAre("frame_1.png", "frame_9.png", "frame_10.png", "frame_100.png"));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].index, static_cast<std::int64_t>(i));
    EXPECT_DOUBLE_EQ(frames[i].timestamp_s, static_cast<double>(i) / 30);
    EXPECT_EQ(frames[i].error, "");
  }
  EXPECT_EQ(frames[2].image.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 10, 245));
}

TEST_F(FrameFiles, APrintfPatternTakesTheFilesThatPrintfWouldName) {
  for (const char* name : {"f_0002.png", "f_0010.png", "f_0001.png", "f_10000.png", "f_00003.png", "f_5.png",
                           "f_0007.jpg", "g_0001.png", "f_abcd.png"}) {
    save(name, image_of(1));
  }
  EXPECT_THAT(names(all({path("f_%04d.png")})), ElementsAre("f_0001.png", "f_0002.png", "f_0010.png", "f_10000.png"));
  EXPECT_THAT(names(all({path("f_%d.png")})), ElementsAre("f_5.png", "f_10000.png"));
  EXPECT_THAT(refusal({path("f_%06d.png")}), HasSubstr("no file matches this pattern"));
}

TEST_F(FrameFiles, AGlobComesInNaturalOrder) {
  for (const char* name : {"a10.png", "a9.png", "b1.png"}) save(name, image_of(1));
  EXPECT_THAT(names(all({path("a*.png")})), ElementsAre("a9.png", "a10.png"));
  EXPECT_THAT(names(all({path("[ab]1*.png")})), ElementsAre("a10.png", "b1.png"));
  EXPECT_THAT(refusal({path("c*.png")}), HasSubstr("c*.png: no file matches"));
}

TEST_F(FrameFiles, FilesKeepTheOrderGivenAndTimestampsFollowFps) {
  const std::string b = save("b.png", image_of(1));
  const std::string a = save("a.png", image_of(2));
  const std::vector<Frame> frames = all({b, a, b}, {.fps = 4});
  EXPECT_THAT(names(frames), ElementsAre("b.png", "a.png", "b.png"));
  EXPECT_EQ(frames[2].timestamp_s, 0.5);
  EXPECT_EQ(open_frames({b, a})->size(), 2);
  EXPECT_THROW((void)open_frames({a}, {.fps = 0}), Error);
}

TEST_F(FrameFiles, DeepImagesAreScaledAndAlphaIsDropped) {
  const std::string deep = save("deep.png", cv::Mat(24, 32, CV_16UC3, cv::Scalar(65535, 257 * 100, 0)));
  const std::string alpha = save("alpha.png", cv::Mat(24, 32, CV_8UC4, cv::Scalar(1, 2, 3, 4)));
  const std::string gray = save("gray.png", cv::Mat(24, 32, CV_8UC1, cv::Scalar(77)));
  const std::vector<Frame> frames = all({deep, alpha, gray});
  ASSERT_EQ(frames.size(), 3U);
  ASSERT_EQ(frames[0].image.type(), CV_8UC3);
  EXPECT_EQ(frames[0].image.at<cv::Vec3b>(5, 5), cv::Vec3b(255, 100, 0));
  ASSERT_EQ(frames[1].image.type(), CV_8UC3);
  EXPECT_EQ(frames[1].image.at<cv::Vec3b>(5, 5), cv::Vec3b(1, 2, 3));
  ASSERT_EQ(frames[2].image.type(), CV_8UC1);
  EXPECT_EQ(frames[2].image.at<unsigned char>(5, 5), 77);
}

TEST_F(FrameFiles, UnreadableImagesAreFramesWithAnErrorAndTheStreamGoesOn) {
  const std::string good = save("good.png", image_of(1));
  const std::string empty = folder_.write("empty.png", "").string();
  const std::string garbage = folder_.write("garbage.jpg", "no image").string();
  const std::string whole_png = text_of(save("noise.png", [] {
    cv::Mat noise(64, 64, CV_8UC3);
    cv::randu(noise, 0, 255);
    return noise;
  }()));
  const std::string cut = folder_.write("cut.png", whole_png.substr(0, whole_png.size() / 2)).string();
  const std::string floats = save("floats.tiff", cv::Mat(8, 8, CV_32FC3, cv::Scalar(1, 2, 3)));
  const std::vector<Frame> frames = all({good, empty, garbage, cut, floats, good});
  ASSERT_EQ(frames.size(), 6U);
  EXPECT_THAT(frames[1].error, HasSubstr("empty.png: is empty"));
  EXPECT_THAT(frames[2].error, HasSubstr("garbage.jpg: is no image"));
  EXPECT_THAT(frames[3].error, HasSubstr("cut.png: "));
  EXPECT_THAT(frames[4].error, HasSubstr("floats.tiff: has floating-point pixels"));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].index, static_cast<std::int64_t>(i));
    EXPECT_EQ(frames[i].image.empty(), !frames[i].error.empty());
  }
  EXPECT_EQ(frames[5].error, "");
}

TEST_F(FrameFiles, AJpegCutShortIsNoImage) {
  cv::Mat noise(64, 64, CV_8UC3);
  cv::randu(noise, 0, 255);
  const std::string whole = save("whole.jpg", noise);
  const std::string bytes = text_of(whole);
  for (const double share : {0.1, 0.5, 0.95}) {
    const auto kept = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
    const std::vector<Frame> frames = all({folder_.write("cut.jpg", bytes.substr(0, kept)).string()});
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_THAT(frames[0].error, HasSubstr("cut.jpg: the JPEG is cut short"));
  }
  // Cameras append previews and clips behind the picture.
  const std::vector<Frame> frames = all({whole, folder_.write("more.jpg", bytes + "\xFF\xDA appended").string()});
  EXPECT_EQ(frames[0].error, "");
  EXPECT_EQ(frames[1].error, "");
}

TEST_F(FrameFiles, AVideoComesFrameByFrameAtItsRate) {
  const std::vector<Frame> frames = all({video(12)}, {.fps = 99});
  ASSERT_EQ(frames.size(), 12U);
  EXPECT_DOUBLE_EQ(frames[11].timestamp_s, 1.1);
  EXPECT_EQ(frames[11].image.size(), cv::Size(64, 48));
  EXPECT_THAT(frames[11].name, HasSubstr("clip.avi, frame 11"));
  EXPECT_NE(frames[0].image.data, frames[1].image.data) << "each frame has pixels of its own";
}

TEST_F(FrameFiles, AVideoThatEndsInTheMiddleGivesItsFramesAndAWarningWithCounts) {
  const std::string bytes = text_of(video(30));
  const std::string cut = folder_.write("cut.avi", bytes.substr(0, bytes.size() / 2)).string();
  const auto source = open_frames({cut});
  int frames = 0;
  while (source->next()) ++frames;
  EXPECT_GT(frames, 5);
  EXPECT_LT(frames, 25);
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_THAT(source->warnings()[0], HasSubstr("cut.avi: ended after " + std::to_string(frames) + " of 30 frames"));
}

TEST_F(FrameFiles, AWholeVideoGivesNoWarning) {
  const auto source = open_frames({video(5)});
  EXPECT_EQ(source->size(), 5);
  while (source->next()) {
  }
  EXPECT_TRUE(source->warnings().empty());
}

TEST_F(FrameFiles, InputsOfSeveralKindsAreNumberedThrough) {
  const std::string image = save("a.png", image_of(1));
  const std::vector<Frame> frames = all({image, video(3), image}, {.fps = 2});
  ASSERT_EQ(frames.size(), 5U);
  const double timestamps_s[] = {0, 0.5, 0.6, 0.7, 0.8};  // half a second of the image, a tenth of each video frame
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].index, static_cast<std::int64_t>(i));
    EXPECT_NEAR(frames[i].timestamp_s, timestamps_s[i], 1e-12);
  }
}

TEST_F(FrameFiles, WhatIsNotThereIsRefusedAtOnce) {
  EXPECT_THAT(refusal({path("missing.png")}), HasSubstr("missing.png: no such file, folder or camera"));
  fs::create_directories(folder_.path() / "nothing");
  EXPECT_THAT(refusal({path("nothing")}), HasSubstr("nothing: no images in this folder"));
  EXPECT_THAT(refusal({folder_.write("words.txt", "no video").string()}), HasSubstr("words.txt: is neither an image"));
  EXPECT_THAT(refusal({folder_.write("empty.avi", "").string()}), HasSubstr("empty.avi: is neither"));
  EXPECT_THAT(refusal({"987"}, ErrorKind::kDevice), HasSubstr("camera 987: the camera cannot be opened"));
  EXPECT_THAT(refusal({"/dev/null"}, ErrorKind::kDevice), HasSubstr("/dev/null: the camera cannot be opened"));
  EXPECT_THAT(refusal({}), HasSubstr("no input"));
}

}  // namespace
}  // namespace cylpose
