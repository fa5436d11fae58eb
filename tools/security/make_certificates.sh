#!/usr/bin/env bash
# make_certificates.sh DIRECTORY NAME...: makes the files that the nodes of one system need for DDS Security. The first
# run makes a certificate authority and the rules of the domains in DIRECTORY. Each NAME gets a folder with its key, its
# certificate, its permissions and the configuration for Cyclone DDS. See README.md beside this file.
set -euo pipefail

days=3650
# Cyclone DDS refuses domains above 230 here.
domains='<domains><id_range><min>0</min><max>230</max></id_range></domains>'

die() { echo "make_certificates.sh: $*" >&2; exit 1; }

plugin_directory() {
  local file
  for file in /usr/lib/*/libddsc0debian/libdds_security_auth.so /usr/lib/*/libdds_security_auth.so \
    /usr/local/lib/libdds_security_auth.so; do
    [[ ! -e $file ]] || { dirname -- "$file"; return; }
  done
  die "the security plugins of Cyclone DDS are missing; install libddsc0debian"
}

# FILE: signs the file as the authority. The result has the same name with .p7s.
sign() {
  openssl smime -sign -text -in "$1" -out "${1%.xml}.p7s" -signer ca.pem -inkey ca.key 2>/dev/null
}

# KEY: makes a private key that only the owner can read.
new_key() { (umask 077; openssl ecparam -name prime256v1 -genkey -noout -out "$1"); }

make_authority() {
  new_key ca.key
  openssl req -x509 -new -key ca.key -days "$days" -subj "/CN=SFT certificate authority" -out ca.pem
  cat >governance.xml <<EOF
<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
<domain_access_rules><domain_rule>$domains
  <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
  <enable_join_access_control>true</enable_join_access_control>
  <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
  <liveliness_protection_kind>SIGN</liveliness_protection_kind>
  <rtps_protection_kind>NONE</rtps_protection_kind>
  <topic_access_rules><topic_rule>
    <topic_expression>*</topic_expression>
    <enable_discovery_protection>true</enable_discovery_protection>
    <enable_liveliness_protection>false</enable_liveliness_protection>
    <enable_read_access_control>true</enable_read_access_control>
    <enable_write_access_control>true</enable_write_access_control>
    <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
    <data_protection_kind>ENCRYPT</data_protection_kind>
  </topic_rule></topic_access_rules>
</domain_rule></domain_access_rules></dds>
EOF
  sign governance.xml
}

# NAME: permits the node to write and read the four control topics only.
make_permissions() {
  local topic topics=''
  for topic in sft_writer sft_reader sft_heartbeat sft_report; do topics+="<topic>$topic</topic>"; done
  topics="<topics>$topics</topics>"
  cat >"$1/permissions.xml" <<EOF
<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
<permissions><grant name="$1"><subject_name>CN=$1</subject_name>
  <validity><not_before>2020-01-01T00:00:00</not_before><not_after>2037-01-01T00:00:00</not_after></validity>
  <allow_rule>$domains<publish>$topics</publish><subscribe>$topics</subscribe></allow_rule>
  <default>DENY</default>
</grant></permissions></dds>
EOF
  sign "$1/permissions.xml"
}

# NAME PLUGINS: writes the configuration for Cyclone DDS, whose security plugins are in the directory PLUGINS.
make_configuration() {
  local plugins=$2 here
  here=$(pwd)
  cat >"$1/cyclonedds.xml" <<EOF
<CycloneDDS><Domain id="any"><Security>
  <Authentication>
    <Library path="$plugins/libdds_security_auth.so"
      initFunction="init_authentication" finalizeFunction="finalize_authentication"/>
    <IdentityCA>file:$here/ca.pem</IdentityCA>
    <IdentityCertificate>file:$here/$1/certificate.pem</IdentityCertificate>
    <PrivateKey>file:$here/$1/private.key</PrivateKey>
  </Authentication>
  <Cryptographic>
    <Library path="$plugins/libdds_security_crypto.so" initFunction="init_crypto" finalizeFunction="finalize_crypto"/>
  </Cryptographic>
  <AccessControl>
    <Library path="$plugins/libdds_security_ac.so"
      initFunction="init_access_control" finalizeFunction="finalize_access_control"/>
    <PermissionsCA>file:$here/ca.pem</PermissionsCA>
    <Governance>file:$here/governance.p7s</Governance>
    <Permissions>file:$here/$1/permissions.p7s</Permissions>
  </AccessControl>
</Security></Domain></CycloneDDS>
EOF
}

# NAME PLUGINS: makes the folder of a node.
make_node() {
  local plugins=$2
  mkdir -p "$1"
  new_key "$1/private.key"
  openssl req -new -key "$1/private.key" -subj "/CN=$1" |
    openssl x509 -req -CA ca.pem -CAkey ca.key -CAcreateserial -days "$days" -out "$1/certificate.pem" 2>/dev/null
  make_permissions "$1"
  make_configuration "$1" "$plugins"
}

(($# >= 2)) || die "usage: make_certificates.sh DIRECTORY NAME..."
command -v openssl >/dev/null || die "openssl is missing; install it"
directory=$1
shift
for name; do
  [[ $name =~ ^[A-Za-z0-9_-]+$ ]] || die "'$name': a name has letters, digits, _ and - only"
done
plugins=$(plugin_directory)
mkdir -p -- "$directory"
cd -- "$directory"
[[ -e ca.key ]] || make_authority
for name; do
  make_node "$name" "$plugins"
done
