#include "sft/detail/convert.h"

#include <algorithm>
#include <array>
#include <string>

#include "body_writer.h"
#include "sft/detail/sample_format.h"

namespace sft::detail {

namespace {

/// Reads the members of a whole type in the payload's encoding, and puts at most `most_bytes` bytes into
/// Out, a BodyCounter or a BodyWriter.
template <class Out>
class Converter {
 public:
  Converter(const Payload& from, const Out& out, std::uint64_t most_bytes)
      : s_{.body = from.body.data(), .body_bytes = static_cast<std::uint32_t>(from.body.size())},
        byte_order_(from.byte_order),
        is_xcdr2_(from.is_xcdr2),
        out_(out),
        most_bytes_(most_bytes) {}

  WalkStatus whole(const StructType& type) {
    if (structure(type) && s_.body_bytes - at_ > max_trailing_bytes) status_ = WalkStatus::trailing_bytes;
    return status_;
  }

  /// Returns the number of bytes put into Out.
  std::uint64_t written() const { return to_; }

 private:
  bool fail(WalkStatus why) {
    status_ = why;
    return false;
  }

  bool structure(const StructType& type) {
    return std::all_of(type.members.begin(), type.members.end(), [this](const Member& m) {
      if (m.kind == Kind::structure && m.shape == Shape::single) return structure(*m.type);
      return is_xcdr2_ && has_delimiter(m) ? delimited(m) : member(m);
    });
  }

  static bool has_delimiter(const Member& m) {
    return m.shape != Shape::single && (!is_primitive(m.kind) || m.enumeration != nullptr);
  }

  bool delimited(const Member& m) {
    const Extent delimiter = checked_length(s_, at_, byte_order_);
    if (!delimiter) return fail(WalkStatus::truncated);
    at_ = delimiter.first;
    if (!member(m)) return false;
    return at_ == std::uint64_t{delimiter.first} + delimiter.count || fail(WalkStatus::bad_delimiter);
  }

  bool member(const Member& m) {
    std::uint32_t n = m.count;
    if (m.shape == Shape::sequence && !length(n)) return false;
    if (m.kind == Kind::structure) return elements(*m.type, n);
    return m.kind == Kind::string ? strings(n) : block(n, size_of(m.kind));
  }

  bool length(std::uint32_t& n) {
    const Extent extent = checked_length(s_, at_, byte_order_);
    if (!extent) return fail(WalkStatus::truncated);
    if (!make_room(4, sizeof extent.count)) return false;
    to_ = out_.put(to_, &extent.count, sizeof extent.count);
    at_ = extent.first;
    n = extent.count;
    return true;
  }

  bool elements(const StructType& type, std::uint32_t n) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint64_t before = at_;
      if (!structure(type)) return false;
      if (at_ == before) break;  // the loop ends for elements without bytes, whose number may be huge
    }
    return true;
  }

  bool strings(std::uint32_t n) {
    for (std::uint32_t i = 0; i < n; ++i) {
      std::uint32_t with_nul = 0;
      if (!length(with_nul) || !block(with_nul, 1)) return false;
    }
    return true;
  }

  bool block(std::uint32_t n, std::size_t element_bytes) {
    const std::size_t alignment = is_xcdr2_ ? std::min<std::size_t>(element_bytes, 4) : element_bytes;
    const std::uint32_t first = checked_block(s_, at_, n, element_bytes, alignment);
    if (first == no_offset) return fail(WalkStatus::truncated);
    const std::uint64_t bytes = std::uint64_t{n} * element_bytes;
    at_ = first + bytes;
    if (n == 0) return true;
    if (!make_room(element_bytes, bytes)) return false;
    if (byte_order_ == std::endian::native) {
      to_ = out_.put(to_, s_.body + first, bytes);
    } else {
      to_ = out_.put_swapped(to_, s_.body + first, n, element_bytes);
    }
    return true;
  }

  bool make_room(std::size_t alignment, std::uint64_t bytes) {
    if (align_up(to_, alignment) + bytes > most_bytes_) return fail(WalkStatus::too_large);
    to_ = out_.align(to_, alignment);
    return true;
  }

  const SampleState s_;
  const std::endian byte_order_;
  const bool is_xcdr2_;
  const Out out_;
  const std::uint64_t most_bytes_;
  std::uint64_t at_ = 0;  ///< position in the payload's body
  std::uint64_t to_ = 0;  ///< position in the converted body
  WalkStatus status_ = WalkStatus::ok;
};

struct Encoding {
  std::uint16_t code;  ///< the code of big-endian bytes; the next code is that of little-endian bytes
  const char* name;
  bool is_plain;
  bool is_xcdr2;
};

constexpr std::array encodings{
    Encoding{0x0000, "CDR", true, false},     Encoding{0x0006, "CDR2", true, true},
    Encoding{0x0010, "CDR2", true, true},     Encoding{0x0002, "PL_CDR", false, false},
    Encoding{0x0008, "D_CDR2", false, true},  Encoding{0x0014, "D_CDR2", false, true},
    Encoding{0x000a, "PL_CDR2", false, true}, Encoding{0x0012, "PL_CDR2", false, true},
};

std::string hexadecimal(std::uint16_t code) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const int shift : {12, 8, 4, 0}) {
    if (shift == 4) text += ' ';
    text += digits[code >> shift & 15];
  }
  return text;
}

tl::unexpected<Error> refused(const Encoding* encoding, std::uint16_t code) {
  const std::string name =
      encoding == nullptr ? std::string("an unknown encoding")
                          : std::string("the encoding ") + encoding->name + ((code & 1) != 0 ? "_LE" : "_BE");
  return fail(Errc::malformed, "a payload in " + name + " (" + hexadecimal(code) +
                                   "): only plain CDR and CDR2 can be read; let its writer send XCDR1, or "
                                   "mark the type @final where it is written");
}

}  // namespace

Result<Payload> parse_payload(std::span<const std::byte> payload) {
  if (payload.size() < encapsulation_bytes)
    return fail(Errc::malformed, "a payload of less than 4 bytes, which has no encapsulation");
  const auto code = static_cast<std::uint16_t>(std::to_integer<unsigned>(payload[0]) << 8 |
                                               std::to_integer<unsigned>(payload[1]));
  const auto* const encoding = std::find_if(encodings.begin(), encodings.end(),
                                            [&](const Encoding& e) { return e.code == (code & 0xfffe); });
  if (encoding == encodings.end()) return refused(nullptr, code);
  if (!encoding->is_plain) return refused(encoding, code);
  const std::size_t padding = std::to_integer<std::size_t>(payload[3] & std::byte{3});
  const auto body = payload.subspan(encapsulation_bytes);
  if (body.size() < padding) return fail(Errc::malformed, "a payload shorter than its own padding");
  if (body.size() >= no_offset) return fail(Errc::limit_exceeded, "a payload of 4 GiB or more");
  return Payload{.body = body.first(body.size() - padding),
                 .byte_order = (code & 1) != 0 ? std::endian::little : std::endian::big,
                 .is_xcdr2 = encoding->is_xcdr2};
}

ConvertedSize converted_size(const Payload& payload, const StructType& type) noexcept {
  if (!payload.needs_conversion()) return {WalkStatus::ok, static_cast<std::uint32_t>(payload.body.size())};
  Converter converter(payload, BodyCounter(), no_offset - 1);
  const WalkStatus status = converter.whole(type);
  return {status, status == WalkStatus::ok ? static_cast<std::uint32_t>(converter.written()) : 0};
}

WalkStatus convert(const Payload& payload, const StructType& type, std::span<std::byte> body) noexcept {
  if (payload.needs_conversion()) return Converter(payload, BodyWriter(body), body.size()).whole(type);
  if (payload.body.size() > body.size()) return WalkStatus::too_large;
  std::copy(payload.body.begin(), payload.body.end(), body.begin());
  return WalkStatus::ok;
}

}  // namespace sft::detail
