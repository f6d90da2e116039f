// Every encoding that a camera driver may use gives the same grey image.

#include "seater_perception/grey_image.h"

#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "scene.h"
#include "seater_perception/errors.h"

using namespace seater_perception;

namespace {

RawImage rawOf(const cv::Mat& mat, const std::string& encoding) {
  return {encoding, mat.cols, mat.rows, mat.step[0], false, mat.data, mat.step[0] * static_cast<std::size_t>(mat.rows)};
}

/// Smooth everywhere, so that neighbours may stand in for each other (Bayer), 20 .. 240.
cv::Mat ramp() {
  cv::Mat image(24, 32, CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(20 + 5 * x + 3 * y);
  }
  return image;
}

double largestDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

cv::Mat colour(int type, const cv::Scalar& value) {
  return {8, 12, type, value};
}

/// What the middle pixel becomes.
int middle(const cv::Mat& mat, const std::string& encoding) {
  return toGrey(rawOf(mat, encoding)).at<std::uint8_t>(mat.rows / 2, mat.cols / 2);
}

/// A mosaic whose rows begin with these letters: "RG" over "GB" for rggb.
cv::Mat mosaic(const std::string& pattern, int type, const std::map<char, double>& levels) {
  cv::Mat image(10, 12, type);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double level = levels.at(pattern[static_cast<std::size_t>(2 * (y % 2) + x % 2)]);
      if (type == CV_8UC1) {
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(level);
      } else {
        image.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(level);
      }
    }
  }
  return image;
}

std::string reasonOf(const RawImage& image) {
  try {
    toGrey(image);
  } catch (const ImageError& error) {
    return error.what();
  }
  return "";
}

const double kGrey = 0.299 * 200 + 0.587 * 100 + 0.114 * 50;  // of red 200, green 100, blue 50: 124.2
const double kGrey15 = kGrey * 257 * 255 / 32767;

}  // namespace

TEST(GreyImage, mono8SharesTheMemory) {
  const cv::Mat image = ramp();
  const cv::Mat grey = toGrey(rawOf(image, "mono8"));
  EXPECT_EQ(grey.data, image.data);
  EXPECT_EQ(largestDifference(grey, image), 0.0);
}

TEST(GreyImage, rowsMayBeLongerThanTheirPixels) {
  const cv::Mat wide = ramp(), part = wide(cv::Rect(4, 2, 20, 15));
  RawImage raw = rawOf(part, "mono8");
  raw.size = part.step[0] * 14 + 20;  // nothing behind the last pixel
  EXPECT_EQ(largestDifference(toGrey(raw), part), 0.0);
}

TEST(GreyImage, coloursAreWeighed) {
  EXPECT_NEAR(middle(colour(CV_8UC3, {50, 100, 200}), "bgr8"), kGrey, 1);
  EXPECT_NEAR(middle(colour(CV_8UC3, {200, 100, 50}), "rgb8"), kGrey, 1);
  EXPECT_NEAR(middle(colour(CV_8UC4, {50, 100, 200, 7}), "bgra8"), kGrey, 1);
  EXPECT_NEAR(middle(colour(CV_8UC4, {200, 100, 50, 7}), "rgba8"), kGrey, 1);
  // The brightest grey, 124 * 257, needs 15 bits only: 2^15 - 1 becomes 255.
  EXPECT_NEAR(middle(colour(CV_16UC3, {50 * 257, 100 * 257, 200 * 257}), "bgr16"), kGrey15, 1);
  EXPECT_NEAR(middle(colour(CV_16UC3, {200 * 257, 100 * 257, 50 * 257}), "rgb16"), kGrey15, 1);
  EXPECT_NEAR(middle(colour(CV_16UC4, {50 * 257, 100 * 257, 200 * 257, 65535}), "bgra16"), kGrey15, 1);
  EXPECT_NEAR(middle(colour(CV_16UC4, {200 * 257, 100 * 257, 50 * 257, 65535}), "rgba16"), kGrey15, 1);
}

TEST(GreyImage, yuvGivesItsLuma) {
  const cv::Mat luma = ramp(), chroma(luma.size(), CV_8U, cv::Scalar(128));
  cv::Mat uyvy, yuyv;
  cv::merge(std::vector<cv::Mat>{chroma, luma}, uyvy);
  cv::merge(std::vector<cv::Mat>{luma, chroma}, yuyv);
  EXPECT_EQ(largestDifference(toGrey(rawOf(uyvy, "yuv422")), luma), 0.0);
  EXPECT_EQ(largestDifference(toGrey(rawOf(yuyv, "yuv422_yuy2")), luma), 0.0);
}

TEST(GreyImage, bayerPatternsAreToldApart) {
  const std::map<char, double> levels = {{'R', 200}, {'G', 100}, {'B', 50}};
  for (const std::string name : {"rggb", "bggr", "gbrg", "grbg"}) {
    std::string pattern = name;
    for (char& c : pattern) c = static_cast<char>(std::toupper(c));
    const cv::Mat grey = toGrey(rawOf(mosaic(pattern, CV_8UC1, levels), "bayer_" + name + "8"));
    EXPECT_LE(largestDifference(grey, cv::Mat(grey.size(), CV_8U, cv::Scalar(kGrey))), 1.0) << name;
    std::map<char, double> deep = levels;
    for (auto& [letter, level] : deep) level *= 257;
    const cv::Mat grey16 = toGrey(rawOf(mosaic(pattern, CV_16UC1, deep), "bayer_" + name + "16"));
    EXPECT_LE(largestDifference(grey16, cv::Mat(grey16.size(), CV_8U, cv::Scalar(kGrey15))), 1.0) << name;
  }
}

TEST(GreyImage, bayerMovesNothing) {
  const cv::Mat image = ramp();
  for (const char* name : {"bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"}) {
    const cv::Rect inside(1, 1, image.cols - 2, image.rows - 2);
    EXPECT_LE(largestDifference(toGrey(rawOf(image, name))(inside), image(inside)), 1.0) << name;
  }
}

// A camera of `bits` bits with black at 10 % and white at 90 % of its range, in the low bits of 16.
TEST(GreyImage, sixteenBitsKeepContrastWhateverTheSensor) {
  for (int bits = 8; bits <= 16; ++bits) {
    const double full = (1 << bits) - 1;
    cv::Mat image(8, 8, CV_16U, cv::Scalar(0.1 * full));
    image(cv::Rect(0, 0, 4, 8)).setTo(0.9 * full);
    const cv::Mat grey = toGrey(rawOf(image, "mono16"));
    EXPECT_NEAR(grey.at<std::uint8_t>(4, 6), 25.5, 1.0) << bits;
    EXPECT_NEAR(grey.at<std::uint8_t>(4, 1), 229.5, 1.0) << bits;
    image(cv::Rect(0, 0, 1, 8)).setTo(full);  // saturated
    EXPECT_EQ(toGrey(rawOf(image, "mono16")).at<std::uint8_t>(4, 0), 255) << bits;
  }
}

TEST(GreyImage, sixteenBitsThatAreDarkAreStretchedAndNeverClipped) {
  cv::Mat image(8, 8, CV_16U);
  for (int brightest : {300, 1000, 5000, 20000, 65535}) {
    for (int i = 0; i < 64; ++i) image.at<std::uint16_t>(i / 8, i % 8) = static_cast<std::uint16_t>(brightest * i / 63);
    const cv::Mat grey = toGrey(rawOf(image, "mono16"));
    EXPECT_GE(grey.at<std::uint8_t>(7, 7), 127) << brightest;
    const double factor = grey.at<std::uint8_t>(7, 7) / static_cast<double>(brightest);
    for (int i = 0; i < 64; ++i) {
      EXPECT_NEAR(grey.at<std::uint8_t>(i / 8, i % 8), factor * image.at<std::uint16_t>(i / 8, i % 8), 1.1);
    }
  }
  EXPECT_EQ(cv::countNonZero(toGrey(rawOf(cv::Mat::zeros(8, 8, CV_16U), "mono16"))), 0);
}

TEST(GreyImage, byteOrder) {
  cv::Mat little(4, 4, CV_16U, cv::Scalar(0x1234)), big(4, 4, CV_16U, cv::Scalar(0x3412));
  little.at<std::uint16_t>(0, 0) = 0xFF00, big.at<std::uint16_t>(0, 0) = 0x00FF;
  RawImage raw = rawOf(big, "mono16");
  raw.big_endian = true;
  EXPECT_EQ(largestDifference(toGrey(raw), toGrey(rawOf(little, "mono16"))), 0.0);
}

TEST(GreyImage, unknownEncodingsAreNamedBesideTheAllowedOnes) {
  for (const char* encoding : {"32FC1", "16UC1", "", "nv12"}) {
    const std::string reason = reasonOf(rawOf(ramp(), encoding));
    EXPECT_NE(reason.find("'" + std::string(encoding) + "'"), std::string::npos) << reason;
    for (const char* allowed : {"mono8", "bgr8", "yuv422_yuy2", "bayer_grbg16", "rgba16"}) {
      EXPECT_NE(reason.find(allowed), std::string::npos) << reason;
    }
  }
}

TEST(GreyImage, sizesThatDoNotFitAreRefused) {
  RawImage raw = rawOf(ramp(), "bgr8");  // rows are too short for three channels
  EXPECT_NE(reasonOf(raw).find("does not fit"), std::string::npos);
  raw = rawOf(ramp(), "mono8");
  raw.size -= 1;
  EXPECT_NE(reasonOf(raw).find("does not fit"), std::string::npos);
  raw = rawOf(cv::Mat(4, 8, CV_16U, cv::Scalar(300)), "mono16");
  raw.width = 7, raw.height = 3;
  raw.step = 15;  // rows would begin in the middle of a value
  EXPECT_NE(reasonOf(raw).find("whole values"), std::string::npos);
  EXPECT_NE(reasonOf(rawOf(cv::Mat(2, 8, CV_8U, cv::Scalar(3)), "bayer_rggb8")).find("at least 3 x 3"),
            std::string::npos);
  raw = rawOf(ramp(), "mono8");
  raw.height = 0;
  EXPECT_NE(reasonOf(raw).find("empty"), std::string::npos);
}

// The whole way: a marker through every encoding of one grey image; poses as exact as from mono8 (Bayer: a little
// less, its pixels are interpolated).
TEST(GreyImage, aMarkersPoseComesThroughEveryEncoding) {
  const Calibration c = scene::calibration(640.0, 640, 480);
  const scene::Print print{0, 0.1, scene::upright({0.05, -0.03, 0.8}, 0.35)};
  const cv::Mat grey = scene::draw(c, "DICT_4X4_50", {print}, scene::Look(), 3);
  cv::Mat bgr, bgra, yuyv, uyvy, mono16, mono12, bgr16;
  cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
  cv::cvtColor(grey, bgra, cv::COLOR_GRAY2BGRA);
  const cv::Mat chroma(grey.size(), CV_8U, cv::Scalar(128));
  cv::merge(std::vector<cv::Mat>{grey, chroma}, yuyv);
  cv::merge(std::vector<cv::Mat>{chroma, grey}, uyvy);
  grey.convertTo(mono16, CV_16U, 257.0);
  grey.convertTo(mono12, CV_16U, 16.0);
  bgr.convertTo(bgr16, CV_16U, 257.0);
  const std::vector<std::pair<std::string, cv::Mat>> images = {{"mono8", grey},
                                                               {"bgr8", bgr},
                                                               {"rgb8", bgr},
                                                               {"bgra8", bgra},
                                                               {"rgba8", bgra},
                                                               {"yuv422", uyvy},
                                                               {"yuv422_yuy2", yuyv},
                                                               {"mono16", mono16},
                                                               {"mono16", mono12},
                                                               {"bgr16", bgr16},
                                                               {"rgb16", bgr16},
                                                               {"bayer_rggb8", grey},
                                                               {"bayer_bggr8", grey},
                                                               {"bayer_gbrg8", grey},
                                                               {"bayer_grbg8", grey},
                                                               {"bayer_rggb16", mono12},
                                                               {"bayer_bggr16", mono16},
                                                               {"bayer_gbrg16", mono12},
                                                               {"bayer_grbg16", mono16}};
  DockDetector detector(CameraModel::raw(c), scene::defaultDock(), PerceptionParameters(), CameraMount());
  for (const auto& [encoding, image] : images) {
    const auto result = detector.detect(toGrey(rawOf(image, encoding)));
    ASSERT_EQ(result.markers.size(), 1u) << encoding;
    const double error = (result.markers[0].best().pose.translation() - print.T_optical_marker.translation()).norm();
    std::printf("  %-14s %.2f mm\n", encoding.c_str(), 1e3 * error);
    EXPECT_LT(error, encoding.rfind("bayer", 0) == 0 ? 0.002 : 0.001) << encoding;
  }
}
