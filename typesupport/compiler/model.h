// The declarations of one .idl, .msg or .srv file, from which the emitters write C++. Names and typedefs
// are resolved, and everything in the model has a counterpart in C++. The model is plain C, because the IDL
// reader includes idlc's headers, which are not C++.
//
// The front end that fills the model owns all objects to which the model points. The IDL reader leaves
// texts in idlc's tree, and frees its arrays with sft_file_free(). Scoped names begin with "::".
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SFT_DIMENSIONS_MAX = 8 };

// The kinds of sft::detail::Kind, with the primitives first.
enum sft_kind {
  SFT_BOOLEAN,
  SFT_OCTET,
  SFT_CHARACTER,
  SFT_INT8,
  SFT_UINT8,
  SFT_INT16,
  SFT_UINT16,
  SFT_INT32,
  SFT_UINT32,
  SFT_INT64,
  SFT_UINT64,
  SFT_FLOAT32,
  SFT_FLOAT64,
  SFT_STRING,
  SFT_STRUCTURE
};

// A single value, an array (dimension_count > 0) or a sequence of elements.
struct sft_type {
  enum sft_kind kind;     ///< the kind of one element; for an enumeration or bitmask, its integer
  const char* name;       ///< the scoped name
  uint32_t string_bound;  ///< the maximum length of each string in characters; 0: unbounded
  bool is_sequence;
  uint32_t bound;  ///< the maximum number of elements of the sequence; 0: unbounded
  size_t dimension_count;
  uint32_t dimensions[SFT_DIMENSIONS_MAX];  ///< the dimensions of an array, the outermost one first
};

// A value. Its type determines which member of the union is used.
struct sft_value {
  bool is_set;
  union {
    bool boolean;
    char character;
    int64_t integer;   ///< the value of int8 to int64
    uint64_t natural;  ///< the value of octet, uint8 to uint64, or a bitmask
    double real;
    const char* text;  ///< the value of a string; for an enumeration, the enumerator's identifier
  };
};

struct sft_member {
  const char* name;
  struct sft_type type;
  struct sft_value initial;  ///< the default of a single value; unset: value-initialized
  /// The default of a sequence or an array, in the order in which the last index changes fastest.
  struct sft_value* initial_elements;
  /// Number of elements of `initial_elements`; 0: the member is value-initialized.
  size_t initial_element_count;
  bool is_key;
  const char* unit;    ///< the unit of the member; null: no unit is given
  const char* layout;  ///< a rule in the spelling of layout/rule.h; null: no rule is given
};

// An enumerator, or a flag of a bitmask. The value of a flag is its bit.
struct sft_enumerator {
  const char* name;
  uint64_t value;
};

// The kinds of declarations. A service X follows the structs X_Request, X_Response, X_Call and X_Reply, and
// has only its name.
enum sft_declaration_kind { SFT_CONSTANT, SFT_ALIAS, SFT_ENUMERATION, SFT_BITMASK, SFT_STRUCT, SFT_SERVICE };

// A declaration. Its kind determines which members are set.
struct sft_declaration {
  enum sft_declaration_kind kind;
  const char* name;        ///< the scoped name
  struct sft_type type;    ///< the type of a constant or an alias; for an enumeration or bitmask, its integer
  struct sft_value value;  ///< the value of a constant
  struct sft_enumerator* enumerators;
  size_t enumerator_count;
  struct sft_member* members;
  size_t member_count;
};

// All paths are absolute. If files are copies, the paths are those of the originals.
struct sft_file {
  /// The directory where idlc reads a copy of /a/b.idl as <copies>/a/b.idl; "": there are no copies.
  const char* copies;
  const char* path;
  /// The beginning of all scoped names, such as "::my::robot"; null: there is none (emit/enclosed.h).
  const char* outer_namespace;
  const char** includes;  ///< files that this file includes directly
  size_t include_count;
  const char** sources;  ///< this file, and all files that it includes, directly or not
  size_t source_count;
  struct sft_declaration* declarations;  ///< the declarations of this file, in their order
  size_t declaration_count;
  char** texts;  ///< texts that the IDL reader allocated
  size_t text_count;
};

void sft_file_free(struct sft_file* file);

#ifdef __cplusplus
}
#endif
