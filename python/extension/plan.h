// An encoded message that is not yet written to memory. Short pieces are copied into the plan, and arrays
// are referred to. So a large array is copied only once, to the memory where readers will read it, and
// without the GIL.
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
  /// The place of a field whose size does not change any more after the message is encoded.
  struct Place {
    std::string path;
    const StructType::Member* member = nullptr;
    std::size_t offset = 0;
    std::size_t count = 1;  ///< the number of elements; 1 for a single value
  };

  /// Returns the size of the body so far in bytes.
  std::size_t bytes() const { return bytes_; }
  void align(std::size_t alignment);
  void put(const void* data, std::size_t bytes);
  void put_zeros(std::size_t bytes);
  /// Adds the bytes of an array. `owner` keeps the array alive.
  void put_array(const void* data, std::size_t bytes, py::object owner);
  /// Reserves bytes of the body. write() leaves them as they are, or sets them to zero.
  void reserve(std::size_t bytes);
  void note(Place place) { places_.push_back(std::move(place)); }
  std::vector<Place> take_places() { return std::move(places_); }
  /// Writes the body to memory of bytes() bytes. If `zeroed` is true, reserved bytes are set to zero. Can
  /// be called without the GIL.
  void write(std::span<std::byte> body, bool zeroed) const;

 private:
  enum class Source { copied, array, room };
  struct Piece {
    Source source;
    const std::byte* data;  ///< the bytes of an array; null: the piece was copied
    std::size_t offset;     ///< the position of a copied piece in copied_
    std::size_t bytes;
  };

  /// Notes that the next bytes of the body are copied, and returns the end of copied_, where the caller
  /// must insert them.
  std::vector<std::byte>::iterator end_of_copied(std::size_t bytes);

  std::vector<std::byte> copied_;
  std::vector<Piece> pieces_;
  std::vector<py::object> owners_;
  std::vector<Place> places_;
  std::size_t bytes_ = 0;
};

}  // namespace sft::python
