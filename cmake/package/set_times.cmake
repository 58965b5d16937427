# SPDX-License-Identifier: Apache-2.0
# Run by CPack before it packs: gives all files the time SOURCE_DATE_EPOCH, if it is set.
if(DEFINED ENV{SOURCE_DATE_EPOCH})
    execute_process(COMMAND_ERROR_IS_FATAL ANY
        COMMAND find "${CPACK_TEMPORARY_DIRECTORY}" -exec touch --no-dereference --date "@$ENV{SOURCE_DATE_EPOCH}" {} +)
endif()
