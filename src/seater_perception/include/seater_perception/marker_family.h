#pragma once

#include <memory>
#include <string>
#include <vector>

#include "seater_perception/marker_pattern.h"

namespace seater_perception {

/// The bits inside a marker's border, row by row from the top as the print is read: 1 white, 0 black.
using MarkerCode = std::vector<std::vector<int>>;

/// A family of square markers: a code for each id inside a black border. All that the detector knows of a print comes
/// from here. A copy shares the codes and costs nothing.
///
/// A family has a name: one of OpenCV's predefined dictionaries (DICT_4X4_50 ...), or a file <name>.yaml (or .yml, such
/// as cv::aruco::Dictionary::writeDictionary writes) in one of the folders that the environment variable
/// SEATER_MARKER_FAMILIES lists, separated by colons; the workspace's setup.bash puts config/marker_families there.
/// That folder's README.md describes the file. Adding such a file is all that a new family takes: the simulator and the
/// evaluation read the same one (seater_common.marker_family).
class MarkerFamily {
 public:
  static constexpr int kFewestBits = 3, kMostBits = 8;  ///< along a side, of a family given as data
  static constexpr int kWidestBorder = 4;               ///< [cells]

  MarkerFamily();  ///< without markers

  /// From data. `border`: width of the black border [cells]; `correctable_bits`: wrong bits of a code that OpenCV's
  /// search mends (search: opencv). Throws ConfigurationError when there is no code, or one is not a square of the
  /// first one's size.
  MarkerFamily(const std::string& name, std::vector<MarkerCode> codes, int border, int correctable_bits);

  /// By its name, with or without DICT_, or by its file's path, which ends in .yaml or .yml. Throws ConfigurationError
  /// that begins with `key` for an unknown name, and as `load` does.
  static MarkerFamily named(const std::string& name, const std::string& key = "dictionary");
  /// From a family file; its name is the file's. Throws ConfigurationError naming file and key, also when two codes (or
  /// one and itself, turned) differ by too few bits to be told apart after correction, as some of OpenCV's
  /// DICT_ARUCO_ORIGINAL do.
  static MarkerFamily load(const std::string& path);
  /// All names that `named` knows: OpenCV's, then those of the files.
  static std::vector<std::string> names();

  const std::string& name() const;
  int bits() const;                      ///< along a side of the code
  int border() const;                    ///< [cells]
  int cells() const;                     ///< along a side of the black square: bits and both borders
  int count() const;                     ///< of codes: ids are 0 .. count - 1
  int correctableBits() const;           ///< of a code
  const MarkerCode& code(int id) const;  ///< Throws ConfigurationError for an unknown id.
  MarkerPattern pattern(int id) const;   ///< The print of a marker. Throws ConfigurationError for an unknown id.

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace seater_perception
