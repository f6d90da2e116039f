#include "seater_perception/marker_family.h"

#include <utility>

#include "seater_perception/errors.h"

namespace seater_perception {

struct MarkerFamily::Data {
  std::string name;
  std::vector<MarkerCode> codes;
  int bits = 0, border = 1, correctable_bits = 0;
};

namespace {

void requireSquare(const MarkerCode& code, std::size_t bits, const std::string& key) {
  bool square = code.size() == bits;
  for (const auto& row : code) square = square && row.size() == bits;
  if (!square) throw ConfigurationError(key + ": must be " + std::to_string(bits) + " rows of as many bits");
}

void requireRange(int value, int low, int high, const std::string& key) {
  if (value >= low && value <= high) return;
  throw ConfigurationError(key + ": is " + std::to_string(value) + ", must be " + std::to_string(low) + " to " +
                           std::to_string(high));
}

}  // namespace

MarkerFamily::MarkerFamily() : data_(std::make_shared<Data>()) {}

MarkerFamily::MarkerFamily(const std::string& name, std::vector<MarkerCode> codes, int border, int correctable_bits) {
  if (codes.empty()) throw ConfigurationError(name + "/codes: is empty, must have at least one code");
  const int bits = static_cast<int>(codes.front().size());
  requireRange(bits, kFewestBits, kMostBits, name + "/bits");
  requireRange(border, 1, kWidestBorder, name + "/border");
  requireRange(correctable_bits, 0, bits * bits, name + "/correctable_bits");
  for (std::size_t id = 0; id < codes.size(); ++id) {
    requireSquare(codes[id], codes.front().size(), name + "/codes[" + std::to_string(id) + "]");
  }
  data_ = std::make_shared<Data>(Data{name, std::move(codes), bits, border, correctable_bits});
}

const std::string& MarkerFamily::name() const {
  return data_->name;
}

int MarkerFamily::bits() const {
  return data_->bits;
}

int MarkerFamily::border() const {
  return data_->border;
}

int MarkerFamily::cells() const {
  return data_->bits + 2 * data_->border;
}

int MarkerFamily::count() const {
  return static_cast<int>(data_->codes.size());
}

int MarkerFamily::correctableBits() const {
  return data_->correctable_bits;
}

const MarkerCode& MarkerFamily::code(int id) const {
  if (id < 0 || id >= count()) {
    throw ConfigurationError("id: is " + std::to_string(id) + ", must be 0 to " + std::to_string(count() - 1) + " in " +
                             name());
  }
  return data_->codes[static_cast<std::size_t>(id)];
}

MarkerPattern MarkerFamily::pattern(int id) const {
  const MarkerCode& bits = code(id);
  const auto n = static_cast<std::size_t>(cells()), border = static_cast<std::size_t>(data_->border);
  std::vector<std::vector<int>> rows(n, std::vector<int>(n, 0));
  for (std::size_t row = 0; row < bits.size(); ++row) {
    for (std::size_t column = 0; column < bits.size(); ++column)
      rows[row + border][column + border] = bits[row][column];
  }
  return MarkerPattern::fromCells(rows);
}

}  // namespace seater_perception
