// A struct of the model, with the C++ names of its fields and constants.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model.h"

namespace sft::idl {

struct Field {
  const sft_member* idl;
  std::string name;
};

struct Constant {
  const sft_declaration* idl;
  std::string name;
};

/// Refers to the model and must not outlive it.
struct Message {
  std::string_view idl_name;  ///< "sensor_msgs::msg::PointCloud2"
  std::string name;           ///< in C++, "PointCloud2"
  std::string qualified;      ///< in C++, "::sensor_msgs::msg::PointCloud2"
  std::vector<Constant> constants;
  std::vector<Field> fields;

  /// The name of this class in the definition of a nested class at global scope, where C++ allows no leading
  /// "::".
  std::string_view class_head() const { return std::string_view(qualified).substr(2); }
};

/// `declaration` is a struct of `file`. The constants of a struct X are those in the module X_Constants
/// beside it, as in ROS.
Message make_message(const sft_file& file, const sft_declaration& declaration);

/// True if a constant belongs to a struct of this file, and not to its namespace.
bool belongs_to_struct(const sft_file& file, const sft_declaration& constant);

/// True if a loan can reserve the field to be written in place: a sequence of primitives or enumerations.
bool is_reservable(const Field& field);

/// True if the view has points(), which the runtime compiles if the types of the fields are those of a cloud,
/// too.
bool is_cloud(const Message& message);

/// True if LoanSizes and LoanView name the field: it is reservable, or a struct, which may contain such
/// fields.
bool has_loan_size(const Field& field);

}  // namespace sft::idl
