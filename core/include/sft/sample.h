// A received sample of message type T, as a subscriber with requirement R sees it. Its fields are read in
// place:
//
//   field                 a getter returns       ... of an array or a sequence of these
//   number, enumerator    its value              std::span
//   string                std::string_view       a range of std::string_view
//   struct                a view with getters    a range of views
//
// Ranges have random access, and work with range-for and std::ranges. If a mask is declared, the getter of a
// field that is not in the mask does not compile. If fields are recorded, or selected by text, getters return
// sft::Optional (optional.h), which is empty if the sample does not have the field. If fields are recorded,
// getters also record the access.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sft/detail/decode.h"
#include "sft/detail/misuse.h"
#include "sft/detail/struct_in.h"
#include "sft/detail/untyped.h"
#include "sft/detail/view.h"

namespace sft {

/// A message in an object of the program, of which only the fields in `mask` were received. Other fields have
/// their default values.
template <class T>
struct Partial {
  T value{};         ///< owned by this struct
  FieldMask mask{};  ///< the fields of `value` that were received
};

/// A sample, as take() returns it and callbacks get it. `sample->field()` reads a field in place. Spans,
/// strings and ranges that getters return are valid until the sample is destroyed or moved. A sample can be
/// moved, but not copied; it owns its memory, in shared memory or in a buffer, until it is destroyed. Any
/// thread may destroy it, and several threads may read it at once. A program can hold at most
/// SubscriberOptions::max_held samples of one publisher in shared memory.
///
/// A sample is empty if take() found none, or after it was moved away. Only `if (sample)`, info() and
/// to_partial(), which returns an error, may be called on an empty sample. Reading an empty sample ends the
/// program with a line that names the type.
template <class T, Req<T> R = Req<T>(all<T>)>
class Sample {
 public:
  /// The type of the view, which has the getters of the fields.
  using View = detail::ViewOf<T, R>;

  Sample() = default;
  /// For SFT's own code: programs get samples from take() and in callbacks.
  explicit Sample(detail::untyped::Sample&& sample) : sample_(std::move(sample)) {}

  /// Returns false if there is no sample.
  explicit operator bool() const { return static_cast<bool>(sample_); }

  /// The result of operator->(). The operator does not compile on a temporary sample, because the results of
  /// getters would refer to a destroyed sample.
  class Arrow {
   public:
    explicit Arrow(View view) : view_(view) {}
    const View* operator->() const { return &view_; }

   private:
    View view_;
  };
  /// Gives access to the getters: `sample->field()`. Must not be called on an empty sample.
  Arrow operator->() const& { return Arrow(view()); }
  void operator->() const&& = delete;

  /// Returns the view with the getters of the sample. The view is valid until the sample is destroyed or
  /// moved. Must not be called on an empty sample.
  View view() const& {
    if (!sample_) [[unlikely]]
      stop();
    return detail::view_of<T, R>(sample_.state());
  }
  void view() const&& = delete;

  /// Returns sequence, stamps, publisher, and the number of samples lost before this one. Valid as long as
  /// the sample.
  const SampleInfo& info() const& { return sample_.info(); }
  void info() const&& = delete;
  /// Returns the fields that the sample has. Must not be called on an empty sample.
  const FieldMask& mask() const& {
    if (!sample_) [[unlikely]]
      stop();
    return *sample_.state().mask;
  }
  void mask() const&& = delete;
  /// Returns the selection that the sample was made for: the fields and parts that its subscriber has
  /// requested. After a subscriber has changed its selection, samples of the former selection may still
  /// arrive; for these samples the former selection is returned. A sample in shared memory, which has all
  /// fields, is always reduced to the latest selection. If two selections differ only in their conditions,
  /// the later one is returned. The result is null if the subscriber records, if it declares only whole
  /// fields, or if the sample is empty. Valid as long as the sample.
  const Selection* selection() const& { return sample_.selection(); }
  void selection() const&& = delete;
  /// Returns the channels of point clouds that were requested (declared or recorded) but that the sample's
  /// clouds do not have. The result is empty if no channel is missing. The call does not count as reading a
  /// field.
  std::vector<std::string> missing_channels() const { return sample_.missing_channels(type_support<T>()); }
  /// Returns true if a getter has returned an empty value because the bytes are malformed, or because there
  /// was no memory for the part of a field that it had to copy.
  bool malformed() const { return sample_.state().is_malformed(); }

  /// Returns a copy of the whole message. Compiles only if the sample has all fields. Returns an error if the
  /// bytes are malformed, which a faulty program on this host can cause.
  [[nodiscard]] Result<T> to_owned() const
      requires(!R.may_lack() && R.mask == all<T> && R.parts == detail::DeclaredParts{}) {
    static_assert(fits_the_stack,
                  "the struct is too large for the stack: write sample.to_owned(*message), "
                  "where message = std::make_unique<T>()");
    Result<T> value{};
    if (Result<void> copied = to_owned(*value); !copied) value = tl::unexpected(std::move(copied.error()));
    return value;
  }
  /// Copies the whole message to an object of the program, and reuses the memory of that object. This also
  /// works for structs that are too large for the stack. After an error the object may contain some fields
  /// of the sample.
  [[nodiscard]] Result<void> to_owned(T& message) const
      requires(!R.may_lack() && R.mask == all<T> && R.parts == detail::DeclaredParts{}) {
    if (!sample_) return empty_error();
    return decode_to(message);
  }
  /// Returns a copy of the fields that this sample has. Returns the same errors as to_owned().
  [[nodiscard]] Result<Partial<T>> to_partial() const {
    static_assert(fits_the_stack,
                  "the struct is too large for the stack: write sample.to_partial(*partial), "
                  "where partial = std::make_unique<sft::Partial<T>>()");
    Result<Partial<T>> partial{};
    if (Result<void> copied = to_partial(*partial); !copied)
      partial = tl::unexpected(std::move(copied.error()));
    return partial;
  }
  /// Does the same as the function above, but replaces the contents of an object of the program.
  [[nodiscard]] Result<void> to_partial(Partial<T>& partial) const {
    if (!sample_) return empty_error();
    std::destroy_at(&partial.value);
    std::construct_at(&partial.value);
    partial.mask = mask();
    return decode_to(partial.value);
  }

  /// Copies the message to a struct that ROS 2's rosidl made of the same .msg file as T, or to a T. The
  /// sample must have all fields: if the subscriber declares fewer, the call does not compile. If a sample
  /// of recorded or selected fields lacks a field, the function returns an error that names it; if the
  /// subscriber records, the call requests all fields. Of fields of which a part was declared, the struct
  /// gets this part. Other errors are those of to_owned().
  template <class S>
  requires std::is_class_v<S>
  [[nodiscard]] Result<void> fill(S& message) const {
    static_assert(R.may_lack() || R.mask == all<T>,
                  "fill() needs all fields: open the subscriber without a list of fields, or call "
                  "fill_partial(), which returns the fields that it has filled");
    if (!sample_) return empty_error();
    if constexpr (R.may_lack()) {
      if (!detail::note_leaves(sample_.state(), 0, detail::leaf_count_of<T>))
        return tl::unexpected(sample_.error_of_missing(type_support<T>()));
    }
    return decode_to(message);
  }
  /// Copies the fields that this sample has to a struct as above, and returns these fields. The other fields
  /// of the struct keep their values.
  template <class S>
  requires std::is_class_v<S>
  [[nodiscard]] Result<FieldMask> fill_partial(S& message) const {
    if (!sample_) return empty_error();
    return decode_to(message).map([&] { return mask(); });
  }

  /// Returns the encoded sample, valid as long as the sample: 4 bytes of encapsulation, and standard CDR of
  /// the members of the type that are in mask(). If parts of fields were requested, the first call on the
  /// publisher's host makes a copy; the result is empty if there is no memory for the copy.
  std::span<const std::byte> cdr() const& { return sample_.cdr(); }
  void cdr() const&& = delete;

 private:
  /// The function is not inline, so that the code of the many getters stays short.
  [[noreturn, gnu::cold, gnu::noinline]] static void stop() {
    detail::stop_at_empty_sample(detail::TypeTable<T>::type.name);
  }

  static constexpr bool fits_the_stack = sizeof(T) <= (1 << 20);

  template <class S>
  Result<void> decode_to(S& value) const {
    const detail::WalkStatus status =
        detail::decode(sample_.whole_state(), *detail::struct_type_of<T, S>(), &value);
    if (status != detail::WalkStatus::ok) return malformed_error(status);
    return {};
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
