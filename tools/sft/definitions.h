// The definitions of message types in files: those of the user, and those that are installed with SFT.
#pragma once

#include <sft/domain.h>
#include <sft/msg_text.h>
#include <string>

#include "tools/sft/common_options.h"

namespace sft::tool {

/// Returns the type with that name, or the one in that file, PACKAGE/msg/NAME.msg. Looks in the user's
/// directories (CommonOptions::includes) first. Errc::unavailable if no directory has it.
Result<DynamicType> find_definition(const std::string& type, const CommonOptions& common);

/// Returns the definition of the type that an endpoint announces without its fields. Returns an error if
/// there is no definition, or if it defines another type of that name.
Result<DynamicType> definition_of(const DomainSnapshot::Endpoint& endpoint, const CommonOptions& common);

}  // namespace sft::tool
