// Explains why two definitions of one type do not match. What was found is kept, since the same pairs are
// judged again after every event.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "core/control.h"
#include "sft/status.h"
#include "sft/typesupport/type_support.h"

namespace sft::core {

class TypeComparisons {
 public:
  /// Never null. Without a description of `theirs` there is no difference to name.
  std::shared_ptr<const TypeMismatch> compare(const TypeSupport& ours, const Endpoint& theirs);

 private:
  using Hashes = std::pair<std::uint64_t, std::uint64_t>;
  std::map<Hashes, std::shared_ptr<const TypeMismatch>> known_;
};

}  // namespace sft::core
