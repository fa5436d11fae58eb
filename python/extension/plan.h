// An encoded message before it is written to its memory: short pieces are copied, and arrays are referred to.
// So a large array is copied once, to where readers will read it, and without the GIL.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sft/type.h"

namespace sft::python {

namespace py = pybind11;

class Plan {
 public:
  /// The place of a field whose size is fixed once the message is encoded.
  struct Place {
    std::string path;
    const StructType::Member* member = nullptr;
    std::size_t offset = 0;
    std::size_t count = 1;  ///< elements; 1 for a single value
  };

  /// The size of the body so far.
  std::size_t bytes() const { return bytes_; }
  void align(std::size_t alignment);
  void put(const void* data, std::size_t bytes);
  void put_zeros(std::size_t bytes);
  /// Puts the bytes of an array, which `owner` keeps alive.
  void put_array(const void* data, std::size_t bytes, py::object owner);
  /// Leaves room that is not written.
  void reserve(std::size_t bytes);
  void note(Place place) { places_.push_back(std::move(place)); }
  std::vector<Place> take_places() { return std::move(places_); }
  /// Writes everything to memory of bytes() bytes, and zeros where room was left if `zeroed`. Needs no GIL.
  void write(std::span<std::byte> body, bool zeroed) const;

 private:
  enum class Source { copied, array, room };
  struct Piece {
    Source source;
    const std::byte* data;  ///< of an array
    std::size_t offset;     ///< of a copied piece in copied_
    std::size_t bytes;
  };

  /// The end of the bytes to copy, to which the caller appends that number of bytes.
  std::vector<std::byte>::iterator end_of_copied(std::size_t bytes);

  std::vector<std::byte> copied_;
  std::vector<Piece> pieces_;
  std::vector<py::object> owners_;
  std::vector<Place> places_;
  std::size_t bytes_ = 0;
};

}  // namespace sft::python
