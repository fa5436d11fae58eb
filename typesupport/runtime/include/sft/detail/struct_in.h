// Says where the members of a message lie in a struct of the program that is not SFT's own: one that ROS 2's
// rosidl made of the same .msg file, or one with the same members in the same order. With this table a
// message is encoded from that struct, and decoded into it, without a copy in between. Needs no header of
// ROS 2.
//
// The generated TypeTable names the members. A table is made only for structs that a program publishes or
// fills.
#pragma once

#include <concepts>
#include <cstddef>
#include <span>
#include <string>
#include <type_traits>

#include "sft/detail/type_table.h"

namespace sft::detail {

/// True if an element E of a struct has the same values and bytes as an element V of the message.
template <class V, class E>
constexpr bool is_same_element() {
  if constexpr (std::is_same_v<V, E>) return true;
  if constexpr (std::is_same_v<V, std::string> || std::is_same_v<E, std::string>) return false;
  if constexpr (std::is_class_v<V> && std::is_class_v<E>) return true;  // StructIn compares their members
  return std::is_integral_v<V> && std::is_integral_v<E> && sizeof(V) == sizeof(E) &&
         std::is_signed_v<V> == std::is_signed_v<E>;
}

template <class E>
constexpr bool is_wide_string = false;
template <class C, class Traits, class Allocator>
constexpr bool is_wide_string<std::basic_string<C, Traits, Allocator>> = sizeof(C) > 1;

void a_member_of_the_struct_is_bool_but_not_in_the_message();  // is never defined

template <class V, class M>
struct SameMember {
  using Own = ShapeOf<V>;
  using Theirs = ShapeOf<M>;
  static constexpr bool is_wide = is_wide_string<typename Theirs::Element>;
  static_assert(
      !is_wide,
      "wide strings are not sent: make the field a 'string' in the .msg file, and convert the text");
  static_assert(
      is_wide || (Own::shape == Theirs::shape && Own::count == Theirs::count &&
                  is_same_element<typename Own::Element, typename Theirs::Element>()),
      "a member of the struct has another type than in the message: generate both from the same .msg file");
  static constexpr void refuse_bool_unless(Kind kind) {
    // The call does not compile, and the compiler's message shows the name.
    if (std::is_same_v<typename Theirs::Element, bool> && kind != Kind::boolean)
      a_member_of_the_struct_is_bool_but_not_in_the_message();
  }
};

/// True if there is no room for other members in the struct S, except in its padding.
template <class S>
constexpr bool has_no_other_members(std::span<const Member> members) {
  std::size_t end = 0;
  for (const Member& m : members) {
    if (m.offset < end || m.offset - end >= alignof(S)) return false;
    end = m.offset + (m.access == nullptr ? m.count * m.stride : m.access->bytes);
  }
  return sizeof(S) - end < alignof(S);
}

template <class T, class S>
struct StructIn {
  static constexpr auto& members = TypeTable<T>::template members_in<S>;
  static_assert(has_no_other_members<S>(members),
                "the struct has other members than the message, or another order of them: generate both from "
                "the same .msg file");
  static constexpr StructType type{TypeTable<T>::type.name, members};
};

/// A struct that may hold a message T, and that is neither a T nor something that is converted to a T.
template <class S, class T>
concept OtherStruct = std::is_class_v<S> && !std::convertible_to<const S&, const T&> &&
                      !std::convertible_to<const S&, std::span<const T>>;

}  // namespace sft::detail
