# Completes subcommands, options, messages, topics and fields of the command sft in bash.

_sft_names() { # ARGUMENT...: prints the names that sft lists, one per line
  sft "$@" --wait 0.3 --timeout 0.5 2>/dev/null
}

_sft_messages() { # prints the messages that are installed with sft, as package/Name
  local program file
  program=$(command -v sft) || return
  for file in "${program%/*}"/../share/sft/interfaces/*/msg/*.msg; do
    file=${file#*/sft/interfaces/} file=${file%.msg}
    echo "${file/\/msg\///}"
  done
}

_sft() {
  local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} before=${COMP_WORDS[COMP_CWORD - 1]}
  local commands="ls info type echo pub hz bw delay why top doctor record play bag bridge perf"
  local common="--json --no-color --domain --interface --peer --dds --wait --timeout --help"
  COMPREPLY=()

  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$word")
    return
  fi
  if [[ $command == perf ]] && ((COMP_CWORD == 2)); then
    mapfile -t COMPREPLY < <(compgen -W "ping pong pub sub" -- "$word")
    return
  fi
  case $before in
    --like)
      mapfile -t COMPREPLY < <(compgen -W "$(_sft_names ls topics --names)" -- "$word")
      return ;;
    --type)
      mapfile -t COMPREPLY < <(compgen -W "$(_sft_messages)" -- "$word")
      return ;;
    --transport)
      mapfile -t COMPREPLY < <(compgen -W "auto shm udp" -- "$word")
      return ;;
    --svg | --raw)
      mapfile -t COMPREPLY < <(compgen -f -- "$word")
      return ;;
    --fields)
      if [[ $command != type && $command != perf ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$(_sft_names type --fields "${COMP_WORDS[2]}")" -- "$word")
        return
      fi ;;
    --dds | --from-dds | --to-dds)
      mapfile -t COMPREPLY < <(compgen -W "auto always never" -- "$word")
      return ;;
    --interface | --to-interface)
      mapfile -t COMPREPLY < <(compgen -W "$(ls /sys/class/net)" -- "$word")
      return ;;
    --output | -o | --html | --file | -f)
      mapfile -t COMPREPLY < <(compgen -f -- "$word")
      return ;;
    --compression)
      mapfile -t COMPREPLY < <(compgen -W "none lz4 zstd" -- "$word")
      return ;;
    --include | -I)
      mapfile -t COMPREPLY < <(compgen -d -- "$word")
      return ;;
    --domain | --peer | --wait | --timeout | --for | --window | --count | -n | --rate | -r | --every | --wait-for | \
      -w | --split-mb | --split-time | --last | --on | --memory-mb | --start | --remap | --field | --value | --size | \
      --sides | --fail-if | --beside | --from | --to | --to-peer | --defaults | --priority)
      [[ $command == bw && $before == --every ]] || return ;;
  esac

  local own=
  case $command in
    ls) own="--names" ;;
    type) own="--name --fields --include" ;;
    echo) own="--fields --once --count --rate --yaml --csv --full --include" ;;
    pub) own="--rate --once --count --wait-for --reliable --transient-local --include" ;;
    hz) own="--for --window --include" ;;
    bw) own="--fields --every --for --window --include" ;;
    delay) own="--field --published --for --window --include" ;;
    perf)
      own="--type --value --size --like --loan --include --fields --rate --for --reliable --transport --sides --beside"
      own+=" --fail-if --svg --raw" ;;
    why) own="--types" ;;
    top) own="--every --for" ;;
    doctor) own="--quiet" ;;
    record)
      own="--all --output --compression --split-mb --split-time --last --on --memory-mb --for --use-sim-time"
      own+=" --include" ;;
    play) own="--topics --remap --rate --start --for --loop --wait-for-subscribers --clock --include" ;;
    bag) own="--like --output --html --include" ;;
    bridge)
      own="--file --from --from-dds --to --to-interface --to-peer --to-dds --defaults --priority --reliable"
      own+=" --for --include" ;;
  esac
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$own $common" -- "$word")
  elif [[ $command == ls ]]; then
    mapfile -t COMPREPLY < <(compgen -W "nodes topics types endpoints" -- "$word")
  elif [[ $command == bag ]] && ((COMP_CWORD == 2)); then
    mapfile -t COMPREPLY < <(compgen -W "info check repair estimate" -- "$word")
  elif [[ $command == @(play|bag) ]]; then
    mapfile -t COMPREPLY < <(compgen -d -- "$word"; compgen -f -X '!*.@(mcap|db3)' -- "$word")
  elif [[ $command == pub ]] && ((COMP_CWORD == 3)); then
    mapfile -t COMPREPLY < <(compgen -W "auto $(_sft_messages)" -- "$word"; compgen -f -X '!*.msg' -- "$word")
  elif [[ $command == @(info|type|echo|hz|bw|delay|why|record|bridge) || $command == pub && $COMP_CWORD == 2 ]]; then
    local slash=
    [[ $word == /* ]] && slash=/
    mapfile -t COMPREPLY < <(compgen -P "$slash" -W "$(_sft_names ls topics --names)" -- "${word#/}")
  fi
}
complete -F _sft sft
