#include "tools/image_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "seater_perception/errors.h"
#include "seater_perception/grey_image.h"

namespace seater_perception {
namespace {

std::vector<char> bytesOf(const std::string& path) {
  if (std::filesystem::is_directory(path)) throw ImageError("is a folder; name the images in it");
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || bytes.empty()) throw ImageError("cannot be opened, or is empty");
  return bytes;
}

/// A JPEG that ends within its pixels, which is decoded as if the rest were grey. Pixels hold no such markers.
bool isCutOff(const std::vector<char>& bytes) {
  const std::string begin = "\xFF\xD8", pixels = "\xFF\xDA", end = "\xFF\xD9";
  if (bytes.size() < begin.size() || !std::equal(begin.begin(), begin.end(), bytes.begin())) return false;
  const auto last = std::find_end(bytes.begin(), bytes.end(), pixels.begin(), pixels.end());
  return std::search(last, bytes.end(), end.begin(), end.end()) == bytes.end();
}

/// In grey, of the depth that the file has.
cv::Mat decoded(const std::vector<char>& bytes, int more_flags) {
  cv::Mat grey;
  try {
    const cv::Mat view(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));  // is only read
    grey = cv::imdecode(view, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | more_flags);
  } catch (const cv::Exception&) {
    // as good as unreadable
  }
  if (grey.empty()) throw ImageError("cannot be read as an image");
  if (grey.type() != CV_8UC1 && grey.type() != CV_16UC1) {
    throw ImageError("its pixels are of type " + cv::typeToString(grey.type()) +
                     ", must be whole numbers of 8 or 16 bits");
  }
  return grey;
}

bool mayHaveOrientation(const std::vector<char>& bytes) {
  const std::string tags[] = {"Exif", "eXIf"};  // JPEG and WebP; PNG
  return std::any_of(std::begin(tags), std::end(tags), [&](const std::string& tag) {
    return std::search(bytes.begin(), bytes.end(), tag.begin(), tag.end()) != bytes.end();
  });
}

}  // namespace

ImageFile readImageFile(const std::string& path, bool honour_exif) {
  const std::vector<char> bytes = bytesOf(path);
  if (isCutOff(bytes)) throw ImageError("is cut off");
  ImageFile image;
  const cv::Mat stored = decoded(bytes, cv::IMREAD_IGNORE_ORIENTATION);
  image.grey = stored;
  if (honour_exif && mayHaveOrientation(bytes)) {
    image.grey = decoded(bytes, 0);
    image.turned = image.grey.size() != stored.size() || cv::norm(image.grey, stored, cv::NORM_INF) > 0.0;
  }
  if (image.grey.depth() == CV_16U) image.grey = reduceTo8Bits(image.grey);
  return image;
}

}  // namespace seater_perception
