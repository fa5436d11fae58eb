#include "udp_transport/multicast/leaf_sizes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sft::udp {

using detail::Kind;
using detail::Member;
using detail::no_offset;
using detail::Shape;

/// Walks over one sample, and adds up the sizes of its fields.
class LeafSizes::Meter {
 public:
  Meter(LeafSizes& sizes, const detail::SampleState& sample) : to_(sizes), s_(sample) {}

  bool all() {
    std::size_t leaf = 0, slot = 0;
    return indexed(to_.type_, leaf, slot);
  }

 private:
  bool indexed(const StructType& type, std::size_t& leaf, std::size_t& slot) {
    for (const Member& m : type.members) {
      if (m.kind == Kind::structure && m.shape == Shape::single) {
        if (!indexed(*m.type, leaf, slot)) return false;
        continue;
      }
      at_ = __atomic_load_n(s_.index + slot++, __ATOMIC_RELAXED);
      if (is_variable(leaf, leaf_count(m)) && at_ != no_offset && !member(m, leaf, true)) return false;
      leaf += leaf_count(m);
    }
    return true;
  }

  bool is_variable(std::size_t leaf, std::size_t leaves) const {
    return to_.sequences_.any_of(leaf, leaves) || to_.texts_.any_of(leaf, leaves);
  }

  bool structure(const StructType& type, std::size_t leaf) {
    for (const Member& m : type.members) {
      if (s_.mask->any_of(leaf, leaf_count(m)) && !member(m, leaf, false)) return false;
      leaf += leaf_count(m);
    }
    return true;
  }

  /// Measures a member. If `is_last` is true, no other member follows, so the end of the member is not
  /// computed.
  bool member(const Member& m, std::size_t leaf, bool is_last) {
    if (!is_variable(leaf, leaf_count(m))) return skip(m, leaf);
    if (m.kind == Kind::structure && m.shape == Shape::single) return structure(*m.type, leaf);
    std::uint32_t n = m.count;
    if (m.shape == Shape::sequence) {
      const detail::Extent extent = detail::checked_length(s_, at_);
      if (!extent) return false;
      n = extent.count;
      at_ = extent.first;
      add(to_.elements_[leaf], n);
    }
    if (m.kind == Kind::structure)
      return elements(m, leaf + (m.shape == Shape::sequence ? 1 : 0), n, is_last);
    if (m.kind == Kind::string) return strings(leaf, n, is_last);
    return is_last || block(n, detail::size_of(m.kind));
  }

  bool elements(const Member& m, std::size_t leaf, std::uint32_t n, bool is_last) {
    const bool some = s_.mask->any_of(leaf, m.type->leaves);
    const std::uint32_t looked_at = some && is_variable(leaf, m.type->leaves) ? std::min(n, elements_max) : 0;
    for (std::uint32_t i = 0; i < looked_at; ++i) {
      if (!structure(*m.type, leaf)) return false;
    }
    if (is_last || !some) return true;
    at_ = detail::skip_elements(s_, *m.type, leaf, n - looked_at, at_);
    return at_ != no_offset;
  }

  bool strings(std::size_t leaf, std::uint32_t n, bool is_last) {
    for (std::uint32_t i = 0; i < n; ++i) {
      if (is_last && i == elements_max) return true;
      const detail::Extent extent = detail::checked_length(s_, at_);
      if (!extent) return false;
      add(to_.strings_[leaf], extent.count);
      at_ = std::uint64_t{extent.first} + extent.count;
      if (at_ > s_.body_bytes) return false;
    }
    return true;
  }

  bool block(std::uint32_t n, std::size_t element_bytes) {
    const std::uint32_t first = detail::checked_block(s_, at_, n, element_bytes);
    at_ = std::uint64_t{first} + std::uint64_t{n} * element_bytes;
    return first != no_offset;
  }

  bool skip(const Member& m, std::size_t leaf) {
    at_ = detail::skip(s_, m, leaf, at_);
    return at_ != no_offset;
  }

  static void add(Average& average, std::uint64_t value) {
    average.sum += value;
    ++average.count;
  }

  LeafSizes& to_;
  const detail::SampleState& s_;
  std::uint64_t at_ = 0;
};

/// Computes the length of a body. It visits the fields in the order of encoding, and uses averages for
/// fields of variable size. After such a field, the exact position is not known, so padding is an average,
/// too.
class LeafSizes::Sum {
 public:
  Sum(const LeafSizes& sizes, const FieldMask& fields) : sizes_(sizes), fields_(fields) {}

  void structure(const StructType& type, std::size_t leaf) {
    for (const Member& m : type.members) {
      if (fields_.any_of(leaf, leaf_count(m))) member(m, leaf);
      leaf += leaf_count(m);
    }
  }
  double bytes() const { return at_; }

 private:
  void member(const Member& m, std::size_t leaf) {
    if (m.kind == Kind::structure && m.shape == Shape::single) return structure(*m.type, leaf);
    double n = m.count;
    if (m.shape == Shape::sequence) {
      align(4);
      add(4);
      n = value_of(sizes_.elements_[leaf]);
    }
    if (m.kind == Kind::structure)
      return elements(*m.type, leaf + (m.shape == Shape::sequence ? 1 : 0), in_whole(n));
    if (n == 0) return;
    if (m.kind == Kind::string) return strings(value_of(sizes_.strings_[leaf]), in_whole(n));
    align(detail::size_of(m.kind));
    add_some(n, detail::size_of(m.kind));
  }

  void strings(double each, std::uint64_t n) {
    repeat(n, [&] {
      align(4);
      add(4);
      add_some(each, 1);
    });
  }
  void elements(const StructType& type, std::size_t leaf, std::uint64_t n) {
    if (fields_.any_of(leaf, type.leaves)) repeat(n, [&] { structure(type, leaf); });
  }

  /// Adds `n` elements of the same type. The size of an element depends only on the known alignment of its
  /// beginning, so the sizes repeat after a few elements.
  template <class One>
  void repeat(std::uint64_t n, const One& one) {
    struct Begin {
      std::uint64_t left = 0;
      double at = 0;
    };
    std::array<Begin, std::size_t{2} * alignment_max> begins{};
    for (bool repeats = false; n > 0; --n) {
      Begin& begin = begins[sure_ + rest_];
      if (!repeats && begin.left != 0) {
        const std::uint64_t period = begin.left - n;
        at_ += static_cast<double>(n / period) * (at_ - begin.at);
        n %= period;
        repeats = true;
        if (n == 0) return;
      } else if (!repeats) {
        begin = {n, at_};
      }
      one();
    }
  }

  void add(std::uint64_t bytes) {
    at_ += static_cast<double>(bytes);
    rest_ = (rest_ + bytes) % sure_;
  }
  /// Adds `n` items of the length `length`. If `n` is not a whole number, it is an average.
  void add_some(double n, std::size_t length) {
    if (n == std::floor(n)) return add(in_whole(n) * length);
    at_ += n * static_cast<double>(length);
    sure_ = std::min(sure_, length);
    rest_ %= sure_;
  }
  void align(std::size_t alignment) {
    if (alignment <= sure_) return add((alignment - rest_ % alignment) % alignment);
    std::size_t padding = 0;
    for (std::size_t rest = rest_; rest < alignment; rest += sure_) padding += (alignment - rest) % alignment;
    at_ += static_cast<double>(padding) / static_cast<double>(alignment / sure_);
    sure_ = alignment;
    rest_ = 0;
  }

  static std::uint64_t in_whole(double n) { return static_cast<std::uint64_t>(std::llround(n)); }

  static constexpr std::size_t alignment_max = 8;
  const LeafSizes& sizes_;
  const FieldMask& fields_;
  double at_ = 0;
  std::size_t sure_ = alignment_max;  ///< `at_` modulo `sure_` is known, and is `rest_`
  std::size_t rest_ = 0;
};

LeafSizes::LeafSizes(const StructType& type)
    : type_(type),
      leaves_(leaf_count(type)),
      elements_(std::make_unique<Average[]>(leaves_)),
      strings_(std::make_unique<Average[]>(leaves_)),
      sequences_(leaves_),
      texts_(leaves_) {
  std::size_t leaf = 0;
  find_variable(type, leaf);
}

void LeafSizes::find_variable(const StructType& type, std::size_t& leaf) {
  for (const Member& m : type.members) {
    if (m.shape == Shape::sequence) sequences_.insert(leaf);
    if (m.kind == Kind::string) texts_.insert(leaf);
    if (m.kind != Kind::structure || m.shape == Shape::sequence) ++leaf;
    if (m.kind == Kind::structure) find_variable(*m.type, leaf);
  }
}

double LeafSizes::value_of(const Average& average) {
  return std::max(0.0, average.value.load(std::memory_order_relaxed));
}

/// Updates an average with the present sample. An average without any values counts as 0: the elements of an
/// empty sequence have no sizes, and none are needed.
void LeafSizes::settle(Average& average) {
  const double before = average.value.load(std::memory_order_relaxed);
  double value = std::max(before, 0.0);
  if (average.count != 0) {
    const double here = static_cast<double>(average.sum) / static_cast<double>(average.count);
    value = before <= 0 ? here : before + (here - before) / 4;
  }
  average.value.store(value, std::memory_order_relaxed);
  average.sum = average.count = 0;
}

void LeafSizes::measure(const detail::SampleState& sample) noexcept {
  const bool is_sound = Meter(*this, sample).all();
  for (std::size_t leaf = 0; leaf < leaves_; ++leaf) {
    if (!is_sound)
      elements_[leaf].count = elements_[leaf].sum = strings_[leaf].count = strings_[leaf].sum = 0;
    if (!is_sound || !sample.mask->contains(leaf)) continue;
    if (sequences_.contains(leaf)) settle(elements_[leaf]);
    if (texts_.contains(leaf)) settle(strings_[leaf]);
  }
}

bool LeafSizes::known(const FieldMask& fields) const {
  const auto is_measured = [](const Average& average) {
    return average.value.load(std::memory_order_relaxed) != unmeasured;
  };
  return std::ranges::all_of(fields, [&](std::size_t leaf) {
    return (!sequences_.contains(leaf) || is_measured(elements_[leaf])) &&
           (!texts_.contains(leaf) || is_measured(strings_[leaf]));
  });
}

double LeafSizes::bytes(const FieldMask& fields) const {
  Sum sum(*this, fields);
  sum.structure(type_, 0);
  return sum.bytes();
}

}  // namespace sft::udp
