#include "sft/detail/type_description.h"

#include <map>
#include <string>
#include <string_view>

#include "description_format.h"
#include "sft/detail/type_table.h"

namespace sft::detail {

namespace {

using Bytes = std::string;  // std::string, because it is comparable, and short ones need no allocation

void put(Bytes& out, std::uint64_t number) {
  for (; number >= 0x80; number >>= 7) out.push_back(static_cast<char>(number | 0x80));
  out.push_back(static_cast<char>(number));
}

void put(Bytes& out, std::string_view text) {
  put(out, text.size());
  out += text;
}

/// The descriptions of all structs, or of all enumerations, each once and in the order in which they were
/// added.
class Table {
 public:
  std::size_t number_of(const Bytes& entry) {
    const auto [known, is_new] = numbers_.try_emplace(entry, numbers_.size());
    if (is_new) all_ += entry;
    return known->second;
  }
  void append_to(Bytes& out) const {
    put(out, numbers_.size());
    out += all_;
  }

 private:
  std::map<Bytes, std::size_t> numbers_;
  Bytes all_;
};

class Describer {
 public:
  /// Adds the struct and returns its number. The structs that it contains have lower numbers.
  std::size_t add(const StructType& type) {
    if (const auto known = numbers_.find(&type); known != numbers_.end()) return known->second;
    Bytes out;
    put(out, type.name);
    put(out, type.members.size());
    for (const Member& m : type.members) add_member(m, out);
    return numbers_[&type] = structs_.number_of(out);
  }

  Bytes all() const {
    Bytes out(1, static_cast<char>(type_description_version));
    enumerations_.append_to(out);
    structs_.append_to(out);
    return out;
  }

 private:
  void add_member(const Member& m, Bytes& out) {
    const unsigned attributes = (m.bound != 0 ? description::has_bound : 0U) |
                                (m.string_bound != 0 ? description::has_string_bound : 0U) |
                                (m.enumeration != nullptr ? description::has_enumeration : 0U) |
                                (m.unit.empty() ? 0U : description::has_unit) |
                                (m.layout.empty() ? 0U : description::has_layout);
    out.push_back(static_cast<char>(
        static_cast<unsigned>(m.kind) | static_cast<unsigned>(m.shape) << description::shape_shift |
        (m.key ? description::is_key : 0U) | (attributes != 0 ? description::has_attributes : 0U)));
    put(out, m.name);
    if (m.shape == Shape::array) put(out, std::uint64_t{m.count});
    if (m.kind == Kind::structure) put(out, add(*m.type));
    if (attributes == 0) return;
    out.push_back(static_cast<char>(attributes));
    if (m.bound != 0) put(out, std::uint64_t{m.bound});
    if (m.string_bound != 0) put(out, std::uint64_t{m.string_bound});
    if (m.enumeration != nullptr) put(out, add(*m.enumeration));
    if (!m.unit.empty()) put(out, m.unit);
    if (!m.layout.empty()) put(out, m.layout);
  }

  std::size_t add(const EnumType& type) {
    Bytes out;
    put(out, type.name);
    out.push_back(type.is_bitmask ? 1 : 0);
    put(out, type.enumerators.size());
    for (const Enumerator& e : type.enumerators) {
      put(out, e.name);
      put(out, e.value);
    }
    return enumerations_.number_of(out);
  }

  Table enumerations_;
  Table structs_;
  std::map<const StructType*, std::size_t> numbers_;
};

}  // namespace

std::vector<std::byte> describe(const StructType& type) {
  Describer describer;
  describer.add(type);
  const Bytes all = describer.all();
  const auto* first = reinterpret_cast<const std::byte*>(all.data());
  return {first, first + all.size()};
}

}  // namespace sft::detail
