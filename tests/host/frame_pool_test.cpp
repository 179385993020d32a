#include <gtest/gtest.h>

#include <cstdint>
#include <cylpose/frame_pool.hpp>
#include <opencv2/core.hpp>
#include <set>
#include <thread>
#include <vector>

namespace cylpose {
namespace {

constexpr std::size_t kBytes = std::size_t{3} * 20 * 30;

TEST(FramePool, UsesTheSameMemoryAgain) {
  const FramePool pool;
  cv::Mat frame = pool.take(20, 30, CV_8UC3);
  EXPECT_EQ(frame.size(), cv::Size(30, 20));
  EXPECT_EQ(frame.type(), CV_8UC3);
  EXPECT_TRUE(frame.isContinuous());
  const std::uint8_t* pixels = frame.data;
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(pixels) % 4096, 0U);
  EXPECT_EQ(pool.idle_bytes(), 0U);
  cv::Mat also = frame;
  frame.release();
  EXPECT_EQ(pool.idle_bytes(), 0U) << "somebody still has it";
  also.release();
  EXPECT_EQ(pool.idle_bytes(), kBytes);
  EXPECT_EQ(pool.take(20, 30, CV_8UC3).data, pixels);
}

TEST(FramePool, WhatIsInUseIsNotGivenTwice) {
  const FramePool pool;
  std::set<const std::uint8_t*> pixels;
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(pool.take(20, 30, CV_8UC3));
    pixels.insert(frames.back().data);
  }
  EXPECT_EQ(pixels.size(), 5U);
  frames.clear();
  EXPECT_EQ(pool.idle_bytes(), 5 * kBytes);
  static_cast<void>(pool.take(10, 10, CV_8UC1));
  EXPECT_EQ(pool.idle_bytes(), 100U) << "the old size is not kept";
}

TEST(FramePool, MayEndBeforeItsFrames) {
  cv::Mat frame;
  {
    const FramePool pool;
    frame = pool.take(20, 30, CV_8UC3);
  }
  frame.setTo(7);
  EXPECT_EQ(cv::sum(frame)[0], 7 * 20 * 30);
  frame.create(40, 50, CV_8UC1);  // not from the pool, which is gone
  frame.setTo(1);
}

TEST(FramePool, TakesWhatIsReadIntoIt) {
  const FramePool pool;
  const cv::Mat source(20, 30, CV_8UC3, cv::Scalar(1, 2, 3));
  const std::uint8_t* pixels = pool.filled([&](cv::Mat& frame) { source.copyTo(frame); }).data;
  const cv::Mat again = pool.filled([&](cv::Mat& frame) { source.copyTo(frame); });
  EXPECT_EQ(again.data, pixels);
  EXPECT_EQ(cv::norm(again, source), 0);
  EXPECT_TRUE(pool.filled([](cv::Mat&) {}).empty());
}

TEST(FramePool, ServesSeveralThreads) {
  const FramePool pool;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&pool, t] {
      for (int i = 0; i < 500; ++i) {
        cv::Mat frame = pool.take(20, 30, CV_8UC3);
        frame.setTo(t);
        EXPECT_EQ(cv::sum(frame)[0], t * 20 * 30);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(pool.idle_bytes(), 4 * kBytes);
}

}  // namespace
}  // namespace cylpose
