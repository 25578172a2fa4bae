# Which tests of offline/ run when. RAYGRID_LONG_TESTS (tests/run everything) runs all.

# Studies of more data than what the others of their suites test.
set(RAYGRID_STUDIES
  CalibrateRig.DeviationsCountNoiseThatNeighboursShare
  StarDetector.FindsStarsOfAnyNumberOfSegments
  TrueErrors.OfOneLensDoNotGrow/5
  TrueErrors.OfThreeLenses*)

# With sanitizers these take minutes: what they reach, others reach on less data.
set(RAYGRID_SLOW_WITH_SANITIZERS
  LensChoice.Compares*
  LensChoice.Counts*
  LensChoice.Measures*
  LensChoice.TakesTheFewest*
  OutputFolder.Kills*)

set(RAYGRID_LEFT_OUT_TESTS)
if(NOT RAYGRID_LONG_TESTS)
  set(RAYGRID_LEFT_OUT_TESTS ${RAYGRID_STUDIES})
  if(CMAKE_BUILD_TYPE STREQUAL "Sanitized")
    list(APPEND RAYGRID_LEFT_OUT_TESTS ${RAYGRID_SLOW_WITH_SANITIZERS})
  endif()
endif()
