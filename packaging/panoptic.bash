# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
#
# Completion for bash. Commands and options are those that the program's own help names, so none is missing and none too many.
_panoptic_commands() {
  panoptic --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p'
}

_panoptic_options() {
  panoptic "$1" --help 2>/dev/null | grep -oE '^ +(-[a-zA-Z],)?--[a-z-]+' | grep -oE -- '--[a-z-]+'
}

_panoptic() {
  local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} i
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "$(_panoptic_commands) --help --version" -- "$word")
    return
  fi
  # After -- in a batch come the options of run.
  for ((i = 2; i < COMP_CWORD; ++i)); do
    [[ $command == batch && ${COMP_WORDS[i]} == -- ]] && command=run
  done
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_panoptic_options "$command")" -- "$word")
  else
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen -f -- "$word")
  fi
}

complete -F _panoptic panoptic
