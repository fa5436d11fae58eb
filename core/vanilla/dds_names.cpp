#include "core/vanilla/dds_names.h"

#include "core/names/names.h"

namespace sft::core {

namespace {
constexpr std::string_view between = "::";
constexpr std::string_view topic_prefix = "rt/";
constexpr std::string_view dds_namespace = "dds_::";
}  // namespace

std::string dds_topic(std::string_view topic, DdsNames names) {
  if (names == DdsNames::plain) return std::string(without_slash(topic));
  return std::string(topic_prefix) + std::string(without_slash(topic));
}

std::string dds_type(std::string_view type, DdsNames names) {
  if (names == DdsNames::plain) return std::string(type);
  const std::size_t last = type.rfind(between);
  const std::size_t name = last == std::string_view::npos ? 0 : last + between.size();
  return std::string(type.substr(0, name)) + std::string(dds_namespace) + std::string(type.substr(name)) +
         "_";
}

std::optional<std::string> topic_of_dds(std::string_view topic, DdsNames names) {
  if (topic == ros_graph_topic) return std::nullopt;
  if (names == DdsNames::plain) return std::string(topic);
  if (!topic.starts_with(topic_prefix) || topic.size() == topic_prefix.size()) return std::nullopt;
  return std::string(topic.substr(topic_prefix.size()));
}

std::string type_of_dds(std::string_view type, DdsNames names) {
  if (names == DdsNames::plain) return std::string(type);
  const std::size_t at = type.rfind(dds_namespace);
  if (at == std::string_view::npos || !type.ends_with('_')) return std::string(type);
  const std::string_view name = type.substr(at + dds_namespace.size());
  return std::string(type.substr(0, at)) + std::string(name.substr(0, name.size() - 1));
}

std::string ros_type_name(std::string_view type) {
  std::string name(type);
  for (std::size_t at = name.find(between); at != std::string::npos; at = name.find(between, at))
    name.replace(at, between.size(), "/");
  return name;
}

}  // namespace sft::core
