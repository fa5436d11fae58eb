#include "python/extension/plan.h"

#include <cstring>

namespace sft::python {

namespace {

/// The minimum size in bytes of an array that the plan refers to. Smaller arrays are copied into the plan.
constexpr std::size_t least_array_bytes = 512;

}  // namespace

void Plan::align(std::size_t alignment) { put_zeros((alignment - bytes_ % alignment) % alignment); }

std::vector<std::byte>::iterator Plan::end_of_copied(std::size_t bytes) {
  if (bytes > 0 && (pieces_.empty() || pieces_.back().source != Source::copied))
    pieces_.push_back({Source::copied, nullptr, copied_.size(), 0});
  if (bytes > 0) pieces_.back().bytes += bytes;
  bytes_ += bytes;
  return copied_.end();
}

void Plan::put(const void* data, std::size_t bytes) {
  const auto* const first = static_cast<const std::byte*>(data);
  copied_.insert(end_of_copied(bytes), first, first + bytes);
}

void Plan::put_zeros(std::size_t bytes) { copied_.insert(end_of_copied(bytes), bytes, std::byte{}); }

void Plan::put_array(const void* data, std::size_t bytes, py::object owner) {
  if (bytes < least_array_bytes) return put(data, bytes);
  pieces_.push_back({Source::array, static_cast<const std::byte*>(data), 0, bytes});
  owners_.push_back(std::move(owner));
  bytes_ += bytes;
}

void Plan::reserve(std::size_t bytes) {
  pieces_.push_back({Source::room, nullptr, 0, bytes});
  bytes_ += bytes;
}

void Plan::write(std::span<std::byte> body, bool zeroed) const {
  std::byte* to = body.data();
  for (const Piece& piece : pieces_) {
    if (piece.source == Source::copied) std::memcpy(to, copied_.data() + piece.offset, piece.bytes);
    if (piece.source == Source::array) std::memcpy(to, piece.data, piece.bytes);
    if (piece.source == Source::room && zeroed) std::memset(to, 0, piece.bytes);
    to += piece.bytes;
  }
}

}  // namespace sft::python
