#include "core/platform/domain_id.h"

#include <charconv>
#include <string>
#include <string_view>

#include "sft/options.h"

namespace sft::core {

namespace {
constexpr std::uint32_t domain_max = NodeOptions::domain_max;
}  // namespace

Result<std::uint32_t> domain_id(std::optional<std::uint32_t> program, const char* environment) {
  if (program) {
    if (*program <= domain_max) return *program;
    return fail(Errc::invalid_argument, "NodeOptions::domain is " + std::to_string(*program) +
                                            ": DDS domains are the numbers 0 to " +
                                            std::to_string(domain_max));
  }
  const std::string_view text = environment == nullptr ? "" : environment;
  std::uint32_t domain = 0;
  if (text.empty()) return domain;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, domain);
  if (error == std::errc{} && stop == end && domain <= domain_max) return domain;
  return fail(Errc::invalid_argument, "ROS_DOMAIN_ID is '" + std::string(text) +
                                          "': DDS domains are the numbers 0 to " +
                                          std::to_string(domain_max));
}

}  // namespace sft::core
