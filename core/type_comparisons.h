// Explains why two definitions of one type do not match. What was found is kept, since the same pairs are
// judged again after every event.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include "core/control.h"
#include "sft/status.h"
#include "sft/typesupport/type_support.h"

namespace sft::core {

class TypeComparisons {
 public:
  /// Never null. Without a description of `theirs` there is no difference to name.
  std::shared_ptr<const TypeMismatch> compare(const TypeSupport& ours, const Endpoint& theirs);

 private:
  /// The name of the type and the hashes of both definitions; hashes alone leave names of types out.
  using Definitions = std::tuple<std::string, std::uint64_t, std::uint64_t>;
  std::map<Definitions, std::shared_ptr<const TypeMismatch>> known_;
};

}  // namespace sft::core
