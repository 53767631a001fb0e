# Compile the generated C++ of a library in one piece: most of the time is for headers, read once then.
# The generated C repeats names, and stays in pieces.
function(in_one_piece)
  get_property(targets DIRECTORY PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    if(target MATCHES "${PROJECT_NAME}__rosidl_typesupport_(cpp|c|fastrtps_cpp|fastrtps_c|introspection_cpp)$")
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    endif()
  endforeach()
endfunction()
cmake_language(DEFER CALL in_one_piece)
