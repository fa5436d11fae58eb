// Finds the definitions of message types in files: files of the user, and files that are installed with SFT.
#pragma once

#include <sft/domain.h>
#include <sft/msg_text.h>
#include <optional>
#include <string>
#include <string_view>

#include "tools/sft/common_options.h"

namespace sft::tool {

/// Returns the type with the name `type`. If `type` is the path of a file, PACKAGE/msg/NAME.msg, returns
/// the type in that file. The user's directories (CommonOptions::includes) are searched first. The error is
/// Errc::unavailable if no directory has the type.
Result<DynamicType> find_definition(const std::string& type, const CommonOptions& common);

/// Returns the definition of a type that an endpoint announces without its fields. Returns an error if
/// there is no definition, or if the definition is that of another type with the same name. Endpoints of
/// DDS announce the hash of ROS 2 or no hash. Without a hash, only the name is compared.
Result<DynamicType> definition_of(const DomainSnapshot::Endpoint& endpoint, const CommonOptions& common);

/// Returns the lines of constants in the file of a message, if the files define this type. (Types are
/// announced without their constants.)
std::string constants_of(const StructType& type, const CommonOptions& common);

/// Returns the text of the service with the name `service`, such as "std_srvs/SetBool". If `service` is the
/// path of a file, PACKAGE/srv/NAME.srv, returns the text of that file. Returns nothing if no directory has
/// the service.
std::optional<std::string> find_service(std::string_view service, const CommonOptions& common);

}  // namespace sft::tool
