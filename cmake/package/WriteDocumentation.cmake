# Writes manual page and completions: cmake -DPROGRAM=kindling -DSHARE=FOLDER -P FILE.
# SPDX-License-Identifier: Apache-2.0
function(write file)
  execute_process(COMMAND ${PROGRAM} ${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE ${SHARE}/${file} "${text}")
endfunction()
write(man/man1/kindling.1 manual)
execute_process(COMMAND gzip -9nf ${SHARE}/man/man1/kindling.1 COMMAND_ERROR_IS_FATAL ANY)
write(bash-completion/completions/kindling completion bash)
write(zsh/vendor-completions/_kindling completion zsh)
