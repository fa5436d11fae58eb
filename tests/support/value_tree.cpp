#include "tests/support/value_tree.h"

#include <cstring>
#include <ostream>
#include <stdexcept>

namespace sft::test {

namespace {

using namespace detail;

std::size_t leaves_of(const Member& m) {
  if (m.kind != Kind::structure) return 1;
  std::size_t n = m.shape == Shape::sequence ? 1 : 0;
  for (const Member& inner : m.type->members) n += leaves_of(inner);
  return n;
}

class FromOwned {
 public:
  explicit FromOwned(const FieldMask& mask) : mask_(mask) {}

  void members(const StructType& type, std::size_t leaf, const std::byte* object, ValueTree& tree) const {
    for (const Member& m : type.members) {
      const std::size_t leaves = leaves_of(m);
      if (any(leaf, leaves)) tree.inner.push_back(member(m, leaf, object));
      leaf += leaves;
    }
  }

 private:
  bool any(std::size_t leaf, std::size_t leaves) const {
    for (std::size_t i = leaf; i < leaf + leaves; ++i) {
      if (mask_.contains(i)) return true;
    }
    return false;
  }

  ValueTree member(const Member& m, std::size_t leaf, const std::byte* object) const {
    const Elements values = elements_of(m, object);
    ValueTree tree{.name = std::string(m.name), .count = values.count};
    if (is_primitive(m.kind)) {
      tree.bytes.assign(reinterpret_cast<const char*>(values.first), values.count * m.stride);
      return tree;
    }
    const std::size_t element_leaf = leaf + (m.shape == Shape::sequence ? 1 : 0);
    if (m.kind == Kind::structure && !any(element_leaf, leaves_of(m) - (element_leaf - leaf))) return tree;
    for (std::size_t i = 0; i < values.count; ++i) {
      const std::byte* at = values.first + i * m.stride;
      ValueTree& element = m.shape == Shape::single ? tree : tree.inner.emplace_back();
      if (m.kind == Kind::string) {
        element.bytes = *reinterpret_cast<const std::string*>(at);
      } else {
        members(*m.type, element_leaf, at, element);
      }
    }
    return tree;
  }

  const FieldMask& mask_;
};

template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::logic_error(result.error().message);
  return *std::move(result);
}

/// Returns the bytes of the value in CDR.
std::string bytes_of(const DynamicView& view) {
  const DynamicView::Scalar value = value_of(view.scalar());
  if (const auto* text = std::get_if<std::string_view>(&value)) return std::string(*text);
  std::string bytes(size_of(view.kind()), '\0');
  std::visit([&](const auto& v) { std::memcpy(bytes.data(), &v, std::min(bytes.size(), sizeof v)); }, value);
  return bytes;
}

class FromView {
 public:
  explicit FromView(bool by_name) : by_name_(by_name) {}

  void members(const DynamicView& view, ValueTree& tree) const {
    if (by_name_) {
      for (const Member& m : view.type()->members) add(view[m.name], tree);
    } else {
      for (const DynamicView& m : view.members()) add(m, tree);
    }
  }

 private:
  void add(const DynamicView& view, ValueTree& tree) const {
    if (view.error() != nullptr) throw std::logic_error(view.error()->message);
    if (view) tree.inner.push_back(member(view));
  }

  ValueTree member(const DynamicView& view) const {
    ValueTree tree{.name = std::string(view.name()),
                   .count = view.is_collection() ? value_of(view.size()) : 1};
    if (view.is_struct()) {
      members(view, tree);
    } else if (!view.is_collection()) {
      tree.bytes = bytes_of(view);
    } else if (by_name_) {
      for (std::size_t i = 0; i < tree.count && !view.has_only_size(); ++i) element(view[i], tree);
    } else {
      for (const DynamicView& e : view.elements()) element(e, tree);
    }
    return tree;
  }

  void element(const DynamicView& view, ValueTree& tree) const {
    if (view.is_struct()) {
      members(view, tree.inner.emplace_back());
    } else if (view.kind() == Kind::string) {
      tree.inner.push_back({.bytes = bytes_of(view)});
    } else {
      tree.bytes += bytes_of(view);
    }
  }

  bool by_name_;
};

}  // namespace

ValueTree value_tree(const OwnedValue& value, const FieldMask& mask) {
  ValueTree tree;
  FromOwned(mask).members(value.type(), 0, static_cast<const std::byte*>(value.get()), tree);
  return tree;
}

ValueTree value_tree(const DynamicView& view) {
  ValueTree tree;
  FromView(false).members(view, tree);
  return tree;
}

ValueTree value_tree_by_name(const DynamicView& view) {
  ValueTree tree;
  FromView(true).members(view, tree);
  return tree;
}

void PrintTo(const ValueTree& tree, std::ostream* out) {
  *out << tree.name << "(" << tree.count << ")";
  if (!tree.bytes.empty()) *out << "=" << tree.bytes.size() << " bytes";
  if (tree.inner.empty()) return;
  *out << "{";
  for (const ValueTree& inner : tree.inner) PrintTo(inner, out);
  *out << "}";
}

}  // namespace sft::test
