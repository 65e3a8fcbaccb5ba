# SPDX-License-Identifier: MPL-2.0
# Completion of batten for bash: its commands, the options that their --help lists, and the values of these.
_batten_words() {  # WORD LIST…
  mapfile -t COMPREPLY < <(compgen -W "${*:2}" -- "$1")
}
_batten() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]-} value
  if [ "$COMP_CWORD" -eq 1 ]; then
    _batten_words "$word" --help --version "$("$1" --help 2>/dev/null | sed -n 's/^  \([a-z][a-z-]*\)  .*/\1/p')"
    return
  fi
  if [[ $word == -* ]]; then
    _batten_words "$word" "$("$1" "$command" --help 2>/dev/null | sed -n 's/^  \(-h, \)\{0,1\}\(--[a-z-]*\).*/\2/p')"
    return
  fi
  value=FILE
  [[ $before != --* ]] || value=$("$1" "$command" --help 2>/dev/null | sed -n "s/^  $before \([^ ]*\).*/\1/p")
  case $value in
    *"|"*) _batten_words "$word" "${value//|/ }" ;;
    FOLDER) mapfile -t COMPREPLY < <(compgen -d -- "$word") && compopt -o filenames ;;
    FILE | '') mapfile -t COMPREPLY < <(compgen -f -- "$word") && compopt -o filenames ;;
    *) COMPREPLY=() ;;  # a number or a name
  esac
}
complete -F _batten batten
