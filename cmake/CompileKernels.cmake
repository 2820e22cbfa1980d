# irradia_compile_kernels(<render>): lets the executable <render> compile the kernels of IRRADIA_KERNEL_SCENES with the
# build, for this machine's processor, into share/irradia/kernels beside its folder. It finds them there, so that the
# first render of a user, or in a fresh container, does not wait for a compiler. Made anew when device code or settings change.
#
# Kernels fit one kind of processor and one version of PoCL; elsewhere, or where there is no PoCL, render compiles as if
# there were none. This file is also the script that compiles (cmake -D RENDER=.. -D SCENES=.. -D OUTPUT=.. -P ..).

function(irradia_compile_kernels render)
  set(IRRADIA_KERNEL_SCENES "${PROJECT_SOURCE_DIR}/scenes/cornell-box.xml" CACHE STRING
      "Scenes whose kernels are compiled with the build, for methods irradiance and path; empty: none are")
  if(NOT IRRADIA_KERNEL_SCENES)
    return()
  endif()
  set(output "${CMAKE_BINARY_DIR}/share/irradia/kernels")
  set(script "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/CompileKernels.cmake")
  irradia_list_kernels("${PROJECT_SOURCE_DIR}" sources)
  # Kernels know the directions of a hemisphere, for example, which defaults and qualities say.
  list(APPEND sources "${PROJECT_SOURCE_DIR}/include/irradia/Renderer.h" "${PROJECT_SOURCE_DIR}/src/render/quality.cpp")
  add_custom_command(
    OUTPUT "${output}.stamp"
    COMMAND "${CMAKE_COMMAND}" -D "RENDER=$<TARGET_FILE:${render}>" -D "SCENES=${IRRADIA_KERNEL_SCENES}"
            -D "OUTPUT=${output}" -P "${script}"
    DEPENDS ${sources} ${IRRADIA_KERNEL_SCENES} "${script}"
    COMMENT "Compiling device code for this machine's processor"
    VERBATIM)
  add_custom_target(irradia_kernels ALL DEPENDS "${output}.stamp")
  add_dependencies(irradia_kernels ${render})
  install(DIRECTORY "${output}" DESTINATION "${CMAKE_INSTALL_DATADIR}/irradia" OPTIONAL)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE AND DEFINED OUTPUT)
  file(REMOVE_RECURSE "${OUTPUT}")
  execute_process(COMMAND "${RENDER}" --list-devices OUTPUT_VARIABLE devices RESULT_VARIABLE failed ERROR_QUIET)
  string(REGEX MATCH "(^|\n)([0-9]+): [^\n]*Portable Computing Language" pocl "${devices}")
  set(device "${CMAKE_MATCH_2}")
  set(scenes "${SCENES}")
  if(failed OR NOT pocl)
    message("no PoCL device here: the first render compiles kernels")
    set(scenes "")
  endif()
  file(MAKE_DIRECTORY "${OUTPUT}.driver")
  foreach(scene IN LISTS scenes)
    foreach(settings "--spp;1" "--quality;draft" "--quality;medium" "--quality;fine" "--quality;finest"
            "--method;path;--spp;1")
      execute_process(
        COMMAND "${CMAKE_COMMAND}" -E env --unset=IRRADIA_CL_DIR "IRRADIA_KERNEL_CACHE=${OUTPUT}"
                IRRADIA_SHIPPED_KERNELS= "POCL_CACHE_DIR=${OUTPUT}.driver"
                "${RENDER}" "${scene}" ${settings} --device ${device} --width 8 --quiet -o "${OUTPUT}.pfm"
        RESULT_VARIABLE failed ERROR_VARIABLE messages)
      if(failed)
        message("${messages}the first render of ${scene} compiles its kernels")
      endif()
    endforeach()
  endforeach()
  file(REMOVE_RECURSE "${OUTPUT}.driver" "${OUTPUT}.pfm")
  file(TOUCH "${OUTPUT}.stamp")
endif()
