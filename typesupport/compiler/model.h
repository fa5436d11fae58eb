// The declarations of one .idl, .msg or .srv file, from which the emitters write C++. Names and typedefs are
// resolved, and everything in the model has a counterpart in C++. The model is plain C, because the IDL
// reader includes idlc's headers, which are no C++.
//
// The front end that fills the model owns what it points to. The IDL reader leaves texts in idlc's tree, and
// frees its arrays with sft_file_free(). Scoped names begin with "::".
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SFT_DIMENSIONS_MAX = 8 };

// The kinds of sft::detail::Kind; primitives come first.
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
  enum sft_kind kind;     ///< of one element; for an enumeration or bitmask, its integer
  const char* name;       ///< the scoped name
  uint32_t string_bound;  ///< most characters of each string; 0: unbounded
  bool is_sequence;
  uint32_t bound;  ///< most elements of the sequence; 0: unbounded
  size_t dimension_count;
  uint32_t dimensions[SFT_DIMENSIONS_MAX];  ///< outermost first
};

// A value. Its type says which alternative holds it.
struct sft_value {
  bool is_set;
  union {
    bool boolean;
    char character;
    int64_t integer;   ///< of int8 to int64
    uint64_t natural;  ///< of octet, uint8 to uint64, a bitmask
    double real;
    const char* text;  ///< of a string; for an enumeration, the enumerator's identifier
  };
};

struct sft_member {
  const char* name;
  struct sft_type type;
  struct sft_value initial;            ///< of a single value; unset: value-initialized
  struct sft_value* initial_elements;  ///< of a sequence, or of an array in which the last index runs fastest
  size_t initial_element_count;        ///< 0: value-initialized
  bool is_key;
  const char* unit;    ///< null: none given
  const char* layout;  ///< a rule as layout/rule.h spells it; null: none given
};

// An enumerator, or a flag of a bitmask, whose value is its bit.
struct sft_enumerator {
  const char* name;
  uint64_t value;
};

// A service X stands behind the structs X_Request, X_Response, X_Call and X_Reply, and has nothing but its
// name.
enum sft_declaration_kind { SFT_CONSTANT, SFT_ALIAS, SFT_ENUMERATION, SFT_BITMASK, SFT_STRUCT, SFT_SERVICE };

// A declaration. Its kind says which members are set.
struct sft_declaration {
  enum sft_declaration_kind kind;
  const char* name;        ///< the scoped name
  struct sft_type type;    ///< of a constant or an alias; for an enumeration or bitmask, its integer
  struct sft_value value;  ///< of a constant
  struct sft_enumerator* enumerators;
  size_t enumerator_count;
  struct sft_member* members;
  size_t member_count;
};

// All paths are absolute. If files are copies, the paths are those of the originals.
struct sft_file {
  const char* copies;  ///< "", or a directory of copies that idlc reads: /a/b.idl is <copies>/a/b.idl
  const char* path;
  const char*
      outer_namespace;    ///< "::my::robot", with which all scoped names begin; null: none (emit/enclosed.h)
  const char** includes;  ///< files that this file includes directly
  size_t include_count;
  const char** sources;  ///< this file, and all that it includes directly or not
  size_t source_count;
  struct sft_declaration* declarations;  ///< of this file, in their order
  size_t declaration_count;
  char** texts;  ///< texts that the IDL reader allocated
  size_t text_count;
};

void sft_file_free(struct sft_file* file);

#ifdef __cplusplus
}
#endif
