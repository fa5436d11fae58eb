// The definitions of message types in files: those of the user, and those that are installed with SFT.
#pragma once

#include <sft/domain.h>
#include <sft/msg_text.h>
#include <optional>
#include <string>
#include <string_view>

#include "tools/sft/common_options.h"

namespace sft::tool {

/// Returns the type with that name, or the one in that file, PACKAGE/msg/NAME.msg. Looks in the user's
/// directories (CommonOptions::includes) first. Errc::unavailable if no directory has it.
Result<DynamicType> find_definition(const std::string& type, const CommonOptions& common);

/// Returns the definition of the type that an endpoint announces without its fields. Returns an error if
/// there is no definition, or if it defines another type of that name.
Result<DynamicType> definition_of(const DomainSnapshot::Endpoint& endpoint, const CommonOptions& common);

/// The lines of constants in the file of a message, if the files define this type. Types are announced
/// without their constants.
std::string constants_of(const StructType& type, const CommonOptions& common);

/// The text of the service with that name, "std_srvs/SetBool", or in that file, PACKAGE/srv/NAME.srv. Nothing
/// if no directory has it.
std::optional<std::string> find_service(std::string_view service, const CommonOptions& common);

}  // namespace sft::tool
