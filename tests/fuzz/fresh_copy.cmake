# cmake -D FROM=folder -D TO=folder -P fresh_copy.cmake: makes TO the same as FROM, leaving nothing older in it.
file(REMOVE_RECURSE ${TO})
file(COPY ${FROM}/ DESTINATION ${TO})
