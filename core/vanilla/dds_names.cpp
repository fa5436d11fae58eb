#include "core/vanilla/dds_names.h"

#include "core/control/names.h"

namespace sft::core {

namespace {
constexpr std::string_view between = "::";
}

std::string dds_topic(std::string_view topic) { return "rt/" + std::string(without_slash(topic)); }

std::string dds_type(std::string_view type) {
  const std::size_t last = type.rfind(between);
  const std::size_t name = last == std::string_view::npos ? 0 : last + between.size();
  return std::string(type.substr(0, name)) + "dds_::" + std::string(type.substr(name)) + "_";
}

std::string ros_type_name(std::string_view type) {
  std::string name(type);
  for (std::size_t at = name.find(between); at != std::string::npos; at = name.find(between, at))
    name.replace(at, between.size(), "/");
  return name;
}

}  // namespace sft::core
