#include "core/platform/huge_pages.h"

#include <sys/prctl.h>

#include <fstream>

namespace sft::core {

std::string why_no_huge_pages(const std::filesystem::path& root) {
  const std::filesystem::path settings = root / "sys/kernel/mm/transparent_hugepage";
  std::string choices;
  std::getline(std::ifstream(settings / "enabled"), choices);  // a text such as "always [madvise] never"
  if (choices.empty()) return "the kernel has none, or hides it";
  if (choices.find("[never]") != std::string::npos)
    return "the system turns them off (/sys/kernel/mm/transparent_hugepage/enabled)";
  std::size_t bytes = 0;
  std::ifstream(settings / "hpage_pmd_size") >> bytes;
  if (bytes > huge_page_bytes)
    return "one has " + std::to_string(bytes >> 20) + " MiB here, more than most samples";
  if (::prctl(PR_GET_THP_DISABLE, 0, 0, 0, 0) == 1) return "they are turned off for this process (prctl)";
  return "";
}

}  // namespace sft::core
