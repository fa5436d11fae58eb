#include "sft/detail/encode_fault.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sft/detail/encode.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/type_table.h"

namespace sft::detail {

namespace {

/// Visits the selected members of an owned struct in the order of the encoder, and counts the bytes of each
/// leaf without padding. Stops at the first fault.
class FaultFinder {
 public:
  FaultFinder(std::size_t leaves, const FieldMask& mask, std::span<const Reservation> reservations)
      : mask_(mask), reservations_(reservations), bytes_(leaves) {}

  /// Returns a text about the first fault of the value; empty if the value has no fault.
  std::string fault_of(const StructType& type, const void* value) {
    structure(type, static_cast<const std::byte*>(value), 0, "", true);
    return fault_;
  }

  /// Returns the size of each leaf in bytes. Must be called only if there was no fault.
  const std::vector<std::uint64_t>& bytes() const { return bytes_; }

 private:
  void structure(const StructType& type, const std::byte* object, std::size_t leaf, const std::string& path,
                 bool in_slots) {
    for (const Member& m : type.members) {
      if (!fault_.empty()) return;
      if (mask_.any_of(leaf, leaf_count(m))) {
        const std::string name = path + (path.empty() ? "" : ".") + std::string(m.name);
        member(m, object + m.offset, leaf, name, in_slots);
      }
      leaf += leaf_count(m);
    }
  }

  void member(const Member& m, const std::byte* value, std::size_t leaf, const std::string& path,
              bool in_slots) {
    const bool is_struct = m.kind == Kind::structure;
    if (m.shape == Shape::single && is_struct) return structure(*m.type, value, leaf, path, in_slots);
    if (m.shape != Shape::sequence) return elements(m, value, m.count, leaf, path);
    const Reservation* const reserved = in_slots && !is_struct ? reservation(leaf) : nullptr;
    const std::size_t n = reserved != nullptr ? *reserved->length : m.access->size(value);
    const std::uint64_t most = m.bound != 0 ? m.bound : no_offset - 1;
    bytes_[leaf] += 4;
    if (n > most) return fail(path, std::to_string(n) + " elements", most);
    if (reserved != nullptr || m.access->data == nullptr) {
      bytes_[leaf] += n * size_of(m.kind);
    } else {
      elements(m, static_cast<const std::byte*>(m.access->data(value)), n, is_struct ? leaf + 1 : leaf, path);
    }
  }

  void elements(const Member& m, const std::byte* first, std::size_t n, std::size_t leaf,
                const std::string& path) {
    if (m.kind == Kind::string || m.kind == Kind::structure) {
      for (std::size_t i = 0; i < n && fault_.empty(); ++i) {
        const std::string name = m.shape == Shape::single ? path : path + "[" + std::to_string(i) + "]";
        if (m.kind == Kind::structure) {
          structure(*m.type, first + i * m.stride, leaf, name, false);
        } else {
          string(m, *reinterpret_cast<const std::string*>(first + i * m.stride), leaf, name);
        }
      }
      return;
    }
    bytes_[leaf] += n * size_of(m.kind);
    if (m.kind == Kind::boolean && m.shape != Shape::single) booleans(first, n, path);
  }

  void string(const Member& m, const std::string& text, std::size_t leaf, const std::string& path) {
    bytes_[leaf] += 4 + text.size() + 1;
    const std::uint64_t most = m.string_bound != 0 ? m.string_bound : no_offset - 2;
    if (text.size() > most) return fail(path, std::to_string(text.size()) + " characters", most);
    const std::size_t nul = text.find('\0');
    if (nul == std::string::npos) return;
    fault_ = "'" + path + "' has a NUL behind " + std::to_string(nul) +
             " characters; a string ends at its first one";
  }

  void booleans(const std::byte* first, std::size_t n, const std::string& path) {
    const std::byte* const wrong =
        std::find_if(first, first + n, [](std::byte b) { return b > std::byte{1}; });
    if (wrong == first + n) return;
    fault_ = "'" + path + "[" + std::to_string(wrong - first) + "]' is " +
             std::to_string(std::to_integer<int>(*wrong)) + "; a boolean is 0 or 1";
  }

  void fail(const std::string& path, const std::string& size, std::uint64_t most) {
    fault_ = "'" + path + "' has " + size + "; its bound is " + std::to_string(most);
  }

  const Reservation* reservation(std::size_t leaf) const {
    const auto found = std::find_if(reservations_.begin(), reservations_.end(), [&](const Reservation& r) {
      return r.leaf == leaf && r.length.has_value();
    });
    return found == reservations_.end() ? nullptr : &*found;
  }

  const FieldMask& mask_;
  const std::span<const Reservation> reservations_;
  std::vector<std::uint64_t> bytes_;
  std::string fault_;
};

}  // namespace

std::string encode_fault(const TypeSupport& type, const Message& message, const FieldMask& mask,
                         std::size_t bytes_max, std::span<const Reservation> reservations) {
  FaultFinder finder(type.leaves(), mask, reservations);
  if (std::string fault = finder.fault_of(message.type, message.value); !fault.empty()) return fault;
  const EncodedSize size = encoded_size(message.type, message.value, mask, reservations);
  const bool is_endless = size.status != EncodeStatus::ok;
  if (!is_endless && size.bytes <= bytes_max) return "";
  const auto largest = std::max_element(finder.bytes().begin(), finder.bytes().end());
  const auto leaf = static_cast<std::size_t>(largest - finder.bytes().begin());
  return "the message has " + (is_endless ? "4 GiB or more" : std::to_string(size.bytes) + " bytes") + ", " +
         std::to_string(*largest) + " of them in '" + type.path(leaf) + "'; at most " +
         std::to_string(std::min<std::size_t>(bytes_max, no_offset - 1)) + " bytes may be sent";
}

}  // namespace sft::detail
