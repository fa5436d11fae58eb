// A received sample of message type T as a subscriber with requirement R sees it.
#pragma once

#include <cassert>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "sft/detail/decode.h"
#include "sft/detail/untyped.h"
#include "sft/detail/view.h"

namespace sft {

/// An owned message of which only the fields in `mask` were received; the others have their default values.
template <class T>
struct Partial {
  T value{};         ///< owned by this struct
  FieldMask mask{};  ///< the fields of `value` that were received
};

/// What take() returns and callbacks get. `sample->field()` reads a field in place, on first access; spans,
/// strings and ranges that getters return are valid as long as the sample, which must not be moved meanwhile.
/// May be destroyed on any thread; several threads may read it at once.
///
/// It may be empty: take() had nothing to give, or the sample was moved away. Only `if (sample)`, info() and
/// to_partial(), which is an error then, are for such a one. To read its fields is a mistake that an
/// assertion finds in programs that are built with assertions; in others every field of a sample from take()
/// is zero or empty then, and malformed() is true.
template <class T, Req<T> R = Req<T>(all<T>)>
class Sample {
 public:
  using View = detail::ViewOf<T, R>;

  Sample() = default;
  explicit Sample(detail::untyped::Sample&& sample) : sample_(std::move(sample)) {}

  /// False if there is no sample.
  explicit operator bool() const { return static_cast<bool>(sample_); }

  /// The view's getters. Not on a temporary: what they return would be gone at once.
  class Arrow {
   public:
    explicit Arrow(View view) : view_(view) {}
    const View* operator->() const { return &view_; }

   private:
    View view_;
  };
  /// The getters: `sample->field()`. Not of an empty sample.
  Arrow operator->() const& { return Arrow(view()); }
  void operator->() const&& = delete;

  /// All getters of the sample. Valid as long as the sample, which must not be moved meanwhile. Not of an
  /// empty sample.
  View view() const& {
    assert(sample_ && "an empty sample is read: ask `if (sample)` first, take() had nothing to give");
    return detail::view_of<T, R>(sample_.state());
  }
  void view() const&& = delete;

  /// Sequence, stamps, publisher, and what was lost before this sample. Valid as long as the sample.
  const SampleInfo& info() const& { return sample_.info(); }
  void info() const&& = delete;
  /// Not of an empty sample.
  const FieldMask& mask() const& {
    assert(sample_ && "an empty sample is asked for its mask: ask `if (sample)` first");
    return *sample_.state().mask;
  }
  void mask() const&& = delete;
  /// Whether a getter met bytes that are not what they claim to be (and returned an empty value).
  bool malformed() const { return sample_.state().is_malformed(); }

  /// The whole message; copies. Only for samples that have all fields. An error where the bytes are not what
  /// they claim to be, which a broken program on this host can cause.
  Result<T> to_owned() const requires(!R.is_recorded && R.mask == all<T>) {
    if (!sample_) return empty_error();
    Result<T> value{};
    if (const detail::WalkStatus status = decode_to(*value); status != detail::WalkStatus::ok)
      value = malformed_error(status);
    return value;
  }
  /// The fields that this sample has; copies.
  Result<Partial<T>> to_partial() const {
    if (!sample_) return empty_error();
    Result<Partial<T>> partial{};
    partial->mask = mask();
    if (const detail::WalkStatus status = decode_to(partial->value); status != detail::WalkStatus::ok)
      partial = malformed_error(status);
    return partial;
  }

  /// Encapsulation and body as they are: standard CDR of the type projected to mask().
  std::span<const std::byte> cdr() const& { return sample_.cdr(); }
  void cdr() const&& = delete;

 private:
  detail::WalkStatus decode_to(T& value) const {
    return detail::decode(sample_.state(), detail::TypeTable<T>::type, &value);
  }
  static tl::unexpected<Error> empty_error() {
    return fail(Errc::unavailable, "the sample is empty: take() had nothing to give");
  }
  tl::unexpected<Error> malformed_error(detail::WalkStatus status) const {
    sample_.state().flag_malformed();
    return fail(Errc::malformed, std::string("not a ") + std::string(detail::TypeTable<T>::type.name) + ": " +
                                     to_string(status));
  }

  detail::untyped::Sample sample_;
};

}  // namespace sft
